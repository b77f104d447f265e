// The directions in which "up" lay in the body at rest: the two halves of the sphere, areas true (Lambert).
const sphere = (() => {
  const STEPS = 8;
  const center = (d, half) => {
    const [x, y, z] = [d[0], d[1], half * d[2]];
    const k = Math.sqrt(1 / (1 + Math.max(0, z)));
    return [half * y * -k, -x * k];  // front at the top of the page; the lower half is seen from below
  };

  // Corner points along the rim of one of the 24 parts: page_model.h says how they are numbered.
  function rim(part) {
    const face = part >> 2, axis = face >> 1, sign = face & 1 ? -1 : 1;
    const a = part & 1 ? 1 : -1, b = part & 2 ? 1 : -1;
    const points = [];
    const put = (u, v) => {
      const d = [0, 0, 0];
      d[axis] = sign;
      d[(axis + 1) % 3] = a * u;
      d[(axis + 2) % 3] = b * v;
      const n = Math.hypot(...d);
      points.push(d.map((c) => c / n));
    };
    for (let i = 0; i < STEPS; i++) put(i / STEPS, 0);
    for (let i = 0; i < STEPS; i++) put(1, i / STEPS);
    for (let i = 0; i < STEPS; i++) put(1 - i / STEPS, 1);
    for (let i = 0; i < STEPS; i++) put(0, 1 - i / STEPS);
    return points;
  }

  function draw(canvas, rested, rests, up) {
    const { context: c, width, height } = drawing(canvas);
    const radius = Math.min(width / 4.7, height / 2 - 26);
    for (const half of [1, -1]) {
      const [x0, y0] = [width / 2 - half * radius * 1.18, height / 2 + 8];
      const at = (d) => { const [x, y] = center(d, half); return [x0 + radius * x, y0 + radius * y]; };
      rested.forEach((seconds, part) => {
        const points = rim(part);
        if (half * points.reduce((sum, p) => sum + p[2], 0) <= 0) return;
        c.beginPath();
        points.forEach((p, i) => (i ? c.lineTo(...at(p)) : c.moveTo(...at(p))));
        c.closePath();
        if (seconds > 0) {
          c.fillStyle = colors.after;
          c.globalAlpha = 0.25 + 0.5 * Math.min(1, seconds / 10);
          c.fill();
          c.globalAlpha = 1;
        }
        c.strokeStyle = colors.rule;
        c.lineWidth = 1;
        c.stroke();
      });
      c.strokeStyle = colors.quiet;
      c.beginPath();
      c.arc(x0, y0, radius, 0, 2 * Math.PI);
      c.stroke();
      rests.filter((r) => half * r.up_body[2] > 0).forEach((r) => mark(c, at(r.up_body), 3, colors.ink, true));
      if (up && half * up[2] > 0) mark(c, at(up), 6, colors.accent, false);
      c.fillStyle = colors.ink;
      c.font = '600 12px system-ui, sans-serif';
      c.textAlign = 'center';
      c.textBaseline = 'alphabetic';
      c.fillText(half > 0 ? 'top up' : 'upside down', x0, y0 - radius - 8);
      c.fillStyle = colors.quiet;
      c.font = '11px system-ui, sans-serif';
      c.fillText('front', x0, y0 - radius + 13);
      c.fillText('back', x0, y0 + radius - 6);
      c.fillText(half > 0 ? 'left' : 'right', x0 - radius + 15, y0 + 4);
      c.fillText(half > 0 ? 'right' : 'left', x0 + radius - 16, y0 + 4);
    }
  }

  function mark(c, [x, y], r, color, isFull) {
    c.beginPath();
    c.arc(x, y, r, 0, 2 * Math.PI);
    c.lineWidth = 2.5;
    c.fillStyle = c.strokeStyle = color;
    if (isFull) c.fill(); else c.stroke();
  }

  return { draw };
})();
