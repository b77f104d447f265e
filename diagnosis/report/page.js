// Draws the curves of each finding with uPlot. Tables, ranking and heat map are in the page already, without any script.
(function () {
  'use strict';
  const findings = JSON.parse(document.getElementById('figures').textContent);
  const plots = [];
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const axis = (label) => ({ label, stroke: () => color('--ink'), grid: { stroke: () => color('--rule'), width: 1 }, ticks: { stroke: () => color('--rule') }, labelSize: 22, font: '11px system-ui', labelFont: '12px system-ui' });
  const line = (label, name, extra) => Object.assign({ label, stroke: () => color(name), width: 1.2, points: { show: false } }, extra || {});
  const dots = (label, name) => line(label, name, { paths: () => null, points: { show: true, size: 3, stroke: () => color(name), fill: () => color(name) } });

  const shortened = (label) => (label.length > 60 ? label.slice(0, 58) + ' …' : label);
  const powers = (u, values) => values.map((v) => (v === null ? '' : v.toExponential(0)));

  function add(id, data, series, axes, more) {
    const box = document.getElementById(id);
    if (!box || data[0].length === 0) return;
    const options = Object.assign({ width: box.clientWidth, height: 230, series: [{}].concat(series), axes, legend: { live: false }, cursor: { drag: { x: true, y: false } } }, more || {});
    plots.push({ box, plot: new uPlot(options, data, box) });
  }
  const shadeHeldOut = (t, held) => ({ hooks: { drawClear: [(u) => {
    u.ctx.save();
    u.ctx.fillStyle = color('--held');
    for (let i = 0; i < t.length; i++) {
      if (!held[i]) continue;
      let j = i;
      while (j + 1 < t.length && held[j + 1]) j++;
      const a = u.valToPos(t[i], 'x', true), b = u.valToPos(t[j], 'x', true);
      u.ctx.fillRect(a, u.bbox.top, Math.max(1, b - a), u.bbox.height);
      i = j;
    }
    u.ctx.restore();
  }] } });

  findings.forEach((f, k) => {
    const time = (u, values) => values;
    add('residual-' + k, [f.t, f.before, f.after], [line('before', '--before'), line('after', '--after')],
        [Object.assign(axis('time, s'), { values: time }), axis(f.channel + ', ' + f.unit)],
        Object.assign({ scales: { x: { time: false } } }, shadeHeldOut(f.t, f.held)));
    add('spectrum-' + k, [f.freq, f.psd_before, f.psd_after, f.psd_noise],
        [line('before', '--before'), line('after', '--after'), line('noise', '--noise', { dash: [4, 3] })],
        [axis('frequency, Hz'), Object.assign(axis('power, (' + f.unit + ')²/Hz'), { size: 62, values: powers })],
        { scales: { x: { time: false, distr: f.freq[0] > 0 ? 3 : 1 }, y: { distr: 3 } } });
    const order = f.driver.map((_, i) => i).sort((a, b) => f.driver[a] - f.driver[b]);
    add('driver-' + k, [order.map((i) => f.driver[i]), order.map((i) => f.at_driver[i]), order.map((i) => f.law[i])],
        [dots('residual', '--before'), line('law', '--accent', { width: 2 })],
        [axis(shortened(f.driver_label)), axis(f.channel + ', ' + f.unit)], { scales: { x: { time: false } } });
    f.each.forEach((a, i) => {
      const by = a.x.map((_, j) => j).sort((p, q) => a.x[p] - a.x[q]);
      add('each-' + k + '-' + i, [by.map((j) => a.x[j]), by.map((j) => a.before[j]), by.map((j) => a.after[j])],
          [dots('before', '--before'), dots('after', '--after')],
          [axis(shortened(a.label)), axis(f.channel + ', ' + f.unit)], { scales: { x: { time: false } } });
    });
    const lags = f.acf_before.map((_, i) => i);
    const band = lags.map(() => f.acf_band), under = lags.map(() => -f.acf_band);
    add('acf-' + k, [lags, f.acf_before, f.acf_after, band, under],
        [line('before', '--before'), line('after', '--after'), line('white noise, 95 %: upper', '--noise', { dash: [4, 3] }), line('lower', '--noise', { dash: [4, 3] })],
        [axis('lag, samples'), axis('autocorrelation')], { scales: { x: { time: false } } });
  });
  const resize = () => plots.forEach(({ box, plot }) => plot.setSize({ width: box.clientWidth, height: 230 }));
  window.addEventListener('resize', resize);
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => plots.forEach(({ plot }) => plot.redraw()));
})();
