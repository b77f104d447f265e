// The body as a box with its axes, over a ground with the points of the compass. World ENU, body x front, y left, z up.
const body = (() => {
  const HALF = [1.15, 0.72, 0.26];  // a flat thing that is longer than wide, so that front and top can be told
  const AZIMUTH = -Math.PI / 2 - 0.35, ELEVATION = 0.48;  // the eye: a little west of south, above the horizon
  const GROUND_Z = -1.5, GROUND_R = 2.15;
  // The three other faces have an arrow that is named.
  const FACES = [[0, 1, ''], [0, -1, 'back'], [1, 1, ''], [1, -1, 'right'], [2, 1, ''], [2, -1, 'bottom']];
  const AXES = [['front', 'before'], ['left', 'after'], ['up', 'accent']];

  const rotate = ([x, y, z, w], v) => {
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
  };
  const [ca, sa, ce, se] = [Math.cos(AZIMUTH), Math.sin(AZIMUTH), Math.cos(ELEVATION), Math.sin(ELEVATION)];
  const EYE = [ce * ca, ce * sa, se];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  // Screen right, screen up, towards the eye.
  const view = (v) => [-sa * v[0] + ca * v[1], -se * ca * v[0] - se * sa * v[1] + ce * v[2], dot(EYE, v)];

  // Without a quaternion: the ground alone.
  function draw(canvas, q, yaw, yawSigma, isRelative) {
    const { context: c, width, height } = drawing(canvas);
    const scale = Math.min(width / 5.4, height / 5.3);
    const at = (v) => {
      const [x, y, depth] = view(v);
      const s = scale * 9 / (9 - depth);  // a little perspective
      return [width / 2 + s * x, height * 0.44 - s * y];
    };
    const path = (points, isClosed) => {
      c.beginPath();
      points.forEach((p, i) => (i ? c.lineTo(...at(p)) : c.moveTo(...at(p))));
      if (isClosed) c.closePath();
    };
    ground(c, at, path, yaw, yawSigma, isRelative);
    if (!q) {
      c.fillStyle = colors.quiet;
      return word(c, 'no attitude yet', width / 2, height * 0.44, 15);
    }
    const axes = AXES.map(([label, color], i) => {
      const tip = [0, 0, 0], root = [0, 0, 0];
      tip[i] = [2.05, 1.6, 1.35][i];
      root[i] = HALF[i];
      return { label, color, tip: rotate(q, tip), root: rotate(q, root) };
    });
    axes.filter((a) => dot(EYE, a.tip) < 0).forEach((a) => arrow(c, at, a));
    FACES.forEach((f) => face(c, at, path, q, f));
    axes.filter((a) => dot(EYE, a.tip) >= 0).forEach((a) => arrow(c, at, a));
  }

  // On a rim of the card's colour, so that a word over a line is read.
  function word(c, text, x, y, size) {
    c.font = '600 ' + size + 'px system-ui, sans-serif';
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    c.lineWidth = 3.5;
    c.lineJoin = 'round';
    c.strokeStyle = colors.card;
    c.strokeText(text, x, y);
    c.fillText(text, x, y);
  }

  function ground(c, at, path, yaw, yawSigma, isRelative) {
    const circle = (r, from, to) => Array.from({ length: 49 }, (_, i) => from + ((to - from) * i) / 48).map((a) => [r * Math.cos(a), r * Math.sin(a), GROUND_Z]);
    c.lineWidth = 1;
    c.strokeStyle = colors.rule;
    for (const r of [GROUND_R / 2, GROUND_R]) { path(circle(r, 0, 2 * Math.PI), true); c.stroke(); }
    for (let k = 0; k < 8; k++) {
      const a = (k * Math.PI) / 4;
      path([[0, 0, GROUND_Z], [GROUND_R * Math.cos(a), GROUND_R * Math.sin(a), GROUND_Z]]);
      c.stroke();
    }
    if (isNumber(yaw) && isNumber(yawSigma)) {
      const half = Math.min(Math.PI, Math.max(0.012, 3 * yawSigma));
      path([[0, 0, GROUND_Z], ...circle(GROUND_R, yaw - half, yaw + half)], true);
      c.fillStyle = colors.accent;
      c.globalAlpha = 0.28;
      c.fill();
      c.globalAlpha = 1;
    }
    c.fillStyle = colors.quiet;
    const names = isRelative ? [['start', 0]] : [['E', 0], ['N', 1], ['W', 2], ['S', 3]];
    for (const [name, k] of names) {
      const a = (k * Math.PI) / 2;
      word(c, name, ...at([1.13 * GROUND_R * Math.cos(a), 1.13 * GROUND_R * Math.sin(a), GROUND_Z]), 13);
    }
  }

  function face(c, at, path, q, [axis, sign, label]) {
    const normal = [0, 0, 0];
    normal[axis] = sign;
    const n = rotate(q, normal);
    const center = rotate(q, normal.map((v, i) => v * HALF[i]));
    if (dot(n, [9 * EYE[0] - center[0], 9 * EYE[1] - center[1], 9 * EYE[2] - center[2]]) <= 0) return;  // turned away
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    const corners = [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => {
      const p = normal.map((x, i) => x * HALF[i]);
      p[u] = a * HALF[u];
      p[v] = b * HALF[v];
      return rotate(q, p);
    });
    path(corners, true);
    c.fillStyle = colors.card;
    c.fill();
    const light = Math.max(0, dot(n, [-0.25, -0.45, 0.86]));
    c.fillStyle = axis === 0 && sign > 0 ? colors.before : colors.noise;
    c.globalAlpha = (axis === 0 && sign > 0 ? 0.35 : 0.12) + 0.4 * light;
    c.fill();
    c.globalAlpha = 1;
    c.strokeStyle = colors.ink;
    c.lineWidth = 1.4;
    c.lineJoin = 'round';
    c.stroke();
    if (!label || dot(n, EYE) < 0.5) return;
    c.fillStyle = colors.ink;
    c.font = '600 12px system-ui, sans-serif';
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    c.fillText(label, ...at(center));
  }

  function arrow(c, at, { label, color, tip, root }) {
    const [x0, y0] = at(root), [x1, y1] = at(tip);
    const length = Math.hypot(x1 - x0, y1 - y0);
    c.strokeStyle = c.fillStyle = colors[color];
    c.lineWidth = 2.5;
    c.beginPath();
    c.moveTo(x0, y0);
    c.lineTo(x1, y1);
    c.stroke();
    const [dx, dy] = length > 1e-3 ? [(x1 - x0) / length, (y1 - y0) / length] : [0, 0];
    const head = Math.min(9, length);
    c.beginPath();
    c.moveTo(x1 + 4 * dx, y1 + 4 * dy);
    c.lineTo(x1 - head * dx + 0.5 * head * dy, y1 - head * dy - 0.5 * head * dx);
    c.lineTo(x1 - head * dx - 0.5 * head * dy, y1 - head * dy + 0.5 * head * dx);
    c.fill();
    word(c, label, x1 + (12 + 8 * Math.abs(dx)) * (length > 1e-3 ? dx : 1), y1 + 14 * (length > 1e-3 ? dy : -1), 12);
  }

  return { draw };
})();
