// Draws the plots of a page with uPlot; report/plot.h says what each holds. Words and tables need no script.
(function () {
  'use strict';
  const plots = [];
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const shortened = (label) => (label.length > 60 ? label.slice(0, 58) + ' …' : label);
  const axis = (label) => ({ label: shortened(label), stroke: () => color('--ink'), grid: { stroke: () => color('--rule'), width: 1 }, ticks: { stroke: () => color('--rule') }, labelSize: 22, font: '11px system-ui', labelFont: '12px system-ui' });
  const powers = (u, values) => values.map((v) => (v === null ? '' : v.toExponential(0)));
  const marks = {
    line: {},
    bold: { width: 2 },
    dashed: { dash: [4, 3] },
    dots: { paths: () => null },
  };
  const series = (few) => (c) => Object.assign({ label: c.label, stroke: () => color(c.colour), width: 1.2,
    points: c.mark === 'dots' ? { show: true, size: few ? 9 : 3, stroke: () => color(c.colour), fill: () => color(c.colour) } : { show: false } }, marks[c.mark]);

  const shades = (x, shaded) => [(u) => {
    u.ctx.save();
    u.ctx.fillStyle = color('--held');
    for (let i = 0; i < x.length; i++) {
      if (!shaded[i]) continue;
      let j = i;
      while (j + 1 < x.length && shaded[j + 1]) j++;
      const a = u.valToPos(x[i], 'x', true), b = u.valToPos(x[j], 'x', true);
      u.ctx.fillRect(a, u.bbox.top, Math.max(1, b - a), u.bbox.height);
      i = j;
    }
    u.ctx.restore();
  }];

  for (const p of JSON.parse(document.getElementById('plots').textContent)) {
    const box = document.getElementById(p.id);
    if (!box || p.x.length === 0) continue;
    const y = axis(p.y_label);
    plots.push({ box, plot: new uPlot({
      width: box.clientWidth, height: 230, series: [{}].concat(p.curves.map(series(p.x.length < 40))), legend: { live: false }, cursor: { drag: { x: true, y: false } },
      axes: [axis(p.x_label), p.log_y ? Object.assign(y, { size: 62, values: powers }) : y],
      scales: { x: { time: false, distr: p.log_x ? 3 : 1 }, y: { distr: p.log_y ? 3 : 1 } },
      hooks: { drawClear: p.shaded.length ? shades(p.x, p.shaded) : [] },
    }, [p.x].concat(p.curves.map((c) => c.y)), box) });
  }
  window.addEventListener('resize', () => plots.forEach(({ box, plot }) => plot.setSize({ width: box.clientWidth, height: 230 })));
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.forEach(({ plot }) => plot.redraw()));
})();
