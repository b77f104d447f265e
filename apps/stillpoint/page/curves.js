// Roll, pitch and yaw of the last half minute with their bands of 3 sigma.
const curves = (() => {
  const SPAN_S = 30, LEAST_RANGE_DEG = 4, HEIGHT = 165;
  const ANGLES = [['roll', 'before'], ['pitch', 'after'], ['yaw', 'accent']];
  const points = [];  // {t, rpy, sigma, rest}, angles in radians or null
  const plots = [];

  function add(t, rpy, sigma, rest) {
    points.push({ t, rpy: rpy && isNumber(rpy[0]) ? rpy : null, sigma, rest });
    while (points.length && t - points[0].t > SPAN_S) points.shift();
  }

  // A turn through 180 degrees is a step of the number, not of the body: the curve runs on, and the axis counts anew.
  const withinTurn = (degrees) => degrees - 360 * Math.ceil((degrees - 180) / 360);
  function columns(axis, now) {
    const t = [], value = [], high = [], low = [];
    let before = null;
    for (const p of points) {
      let v = p.rpy ? p.rpy[axis] * DEG : null;
      if (v !== null && before !== null) v = before + withinTurn(v - before);
      if (v !== null) before = v;
      const band = p.rpy && isNumber(p.sigma[axis]) ? 3 * p.sigma[axis] * DEG : 0;
      t.push(p.t - now);
      value.push(v);
      high.push(v === null ? null : v + band);
      low.push(v === null ? null : v - band);
    }
    return [t, value, high, low];
  }

  const shadeRests = (u) => {
    const now = points.length ? points[points.length - 1].t : 0;
    u.ctx.save();
    u.ctx.fillStyle = colors.held;
    for (let i = 0; i < points.length; i++) {
      if (!points[i].rest) continue;
      let j = i;
      while (j + 1 < points.length && points[j + 1].rest) j++;
      const a = u.valToPos(points[i].t - now, 'x', true), b = u.valToPos(points[j].t - now, 'x', true);
      const left = Math.max(u.bbox.left, a);
      u.ctx.fillRect(left, u.bbox.top, Math.max(1, b - left), u.bbox.height);
      i = j;
    }
    u.ctx.restore();
  };

  // Noise of a body at rest must not look like motion, so the axis never shows less than four degrees.
  const range = (u, low, high) => {
    if (low === null) return [-LEAST_RANGE_DEG / 2, LEAST_RANGE_DEG / 2];
    const middle = (low + high) / 2, half = Math.max(LEAST_RANGE_DEG, 1.15 * (high - low)) / 2;
    return [middle - half, middle + half];
  };

  // Within half a turn; over a whole turn and more the angles run on, or two lines would bear the same number.
  const angleText = (ticks) => {
    const runsOn = ticks[ticks.length - 1] - ticks[0] >= 360;
    return (d) => String(Math.round((runsOn ? d : withinTurn(d)) * 100) / 100).replace('-', '−');
  };

  function create() {
    ANGLES.forEach(([name, color], axis) => {
      const box = byId('curve-' + name);
      const plain = (label, extra) => Object.assign({ label, stroke: () => colors[color], width: 0, points: { show: false } }, extra);
      const scaled = (size, more) => Object.assign({ stroke: () => colors.ink, grid: { stroke: () => colors.rule, width: 1 }, ticks: { stroke: () => colors.rule }, size, font: '11px system-ui' }, more);
      const options = {
        width: box.clientWidth, height: HEIGHT, legend: { show: false }, cursor: { show: false },
        scales: { x: { time: false, range: [-SPAN_S, 0] }, y: { range } },
        series: [{}, plain(name, { width: 1.8 }), plain('+3 sigma', { width: 0.8 }), plain('-3 sigma', { width: 0.8 })],
        bands: [{ series: [2, 3], fill: () => colors[color] + '33' }],
        axes: [scaled(30, { incrs: [5, 10], space: 45, values: (u, v) => v.map((s) => (s === 0 ? 'now' : '−' + -s + ' s')) }),
               scaled(52, { incrs: [0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 45, 90, 180, 360, 720], space: 28, label: name + ', °', labelSize: 18, labelFont: '12px system-ui', values: (u, v) => v.map(angleText(v)) })],
        hooks: { drawClear: [shadeRests] },
      };
      plots.push({ box, axis, plot: new uPlot(options, [[], [], [], []], box) });
    });
  }

  function draw() {
    if (!plots.length) create();
    const now = points.length ? points[points.length - 1].t : 0;
    for (const { plot, axis } of plots) plot.setData(columns(axis, now));
  }

  return {
    add, draw,
    begin: (h) => { points.length = 0; h.t_s.forEach((t, i) => add(t, h.roll_pitch_yaw_rad[i], h.sigma_rpy_rad[i], h.at_rest[i])); },
    resize: () => plots.forEach(({ box, plot }) => plot.setSize({ width: box.clientWidth, height: HEIGHT })),
  };
})();
