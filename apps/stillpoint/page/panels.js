// What changes slowly: calibration, health, rests, latency, counters. Rebuilt once a second.
const panels = (() => {
  const SENSORS = ['acc', 'gyr', 'mag'];
  const UNITS = { acc: ['m/s²', 1], gyr: ['°/s', DEG], mag: ['µT', 1] };
  const row = (...cells) => element('tr', {}, ...cells);
  const cell = (content, kind) => element('td', kind ? { class: kind } : {}, content);
  const head = (content) => element('th', {}, content);
  const replace = (parent, ...children) => parent.replaceChildren(...children);

  // Half of a scale that reaches over all values, in steps that people read: 1, 2, 5.
  function reach(values) {
    const largest = Math.max(1e-9, ...values);
    const power = 10 ** Math.floor(Math.log10(largest));
    return power * [1, 2, 5, 10].find((m) => m * power >= largest);
  }

  function offsets(bias, sd, unit) {
    const LEFT = 14, RIGHT = 306, MIDDLE = (LEFT + RIGHT) / 2;
    const half = reach(bias.map((b, i) => Math.abs(b) + 3 * sd[i]));
    const x = (v) => MIDDLE + ((RIGHT - MIDDLE) * v) / half;
    const picture = svg('svg', { viewBox: '0 0 320 92', role: 'img', 'aria-label': 'Offsets of the axes on a scale from minus to plus ' + half + ' ' + unit });
    picture.append(svg('line', { class: 'zero', x1: MIDDLE, x2: MIDDLE, y1: 2, y2: 72, 'stroke-dasharray': '4 3' }));
    bias.forEach((b, i) => {
      const y = 14 + 22 * i;
      picture.append(svg('line', { class: 'line', x1: LEFT, x2: RIGHT, y1: y, y2: y }), svg('text', { x: 0, y: y + 4 }, 'xyz'[i]));
      if (sd[i] > 0) picture.append(svg('line', { class: 'band', x1: x(b - 3 * sd[i]), x2: x(b + 3 * sd[i]), y1: y, y2: y, 'stroke-width': 7, 'stroke-opacity': 0.35 }));
      picture.append(svg('circle', { class: 'value', cx: x(b), cy: y, r: 4 }));
    });
    for (const [v, anchor, at] of [[-half, 'start', LEFT], [0, 'middle', MIDDLE], [half, 'end', RIGHT]])
      picture.append(svg('text', { class: 'quiet', x: at, y: 88, 'text-anchor': anchor }, (v === 0 ? '0' : short(v)) + (v > 0 ? ' ' + unit : '')));
    return picture;
  }

  function calibrationCard(name, c) {
    const [unit, scale] = UNITS[name];
    const words = CALIBRATION_WORDS[c.status] || ['none', c.status, ''];
    const bias = c.bias.map((b) => (isNumber(b) ? b * scale : 0)), sd = c.bias_sd.map((s) => (isNumber(s) ? s * scale : 0));
    const digits = Math.max(1, Math.min(5, 1 - Math.floor(Math.log10(Math.max(1e-5, ...sd)))));
    const table = element('table', {}, element('thead', {}, row(head('axis'), element('th', { class: 'n' }, 'offset, ' + unit), element('th', { class: 'n' }, '1 sigma'))),
      element('tbody', {}, ...bias.map((b, i) => row(head('xyz'[i]), cell(fixed(b, digits), 'n'), cell(sd[i] > 0 ? '± ' + fixed(sd[i], digits) : 'not known', 'n')))));
    const lack = c.reason || words[2];
    const seen = c.windows + (c.windows === 1 ? ' rest window' : ' rest windows') + ', ' + fixed(c.temp_range_degC[0], 1) + ' to ' + fixed(c.temp_range_degC[1], 1) + ' °C';
    const card = element('div', { class: 'card' }, element('h3', {}, SENSOR_WORDS[name], chip(words)), offsets(bias, sd, unit), table, element('p', { class: 'small' }, seen));
    card.append(lack ? element('p', {}, element('span', { class: 'lack' }, 'Missing: '), lack) : element('p', { class: 'small' }, 'Nothing is missing.'));
    return card;
  }

  function calibration(watch) {
    const box = byId('calibration');
    if (!watch.calibration) return replace(box, element('p', {}, 'No calibration has arrived yet.'));
    replace(box, ...SENSORS.map((name, i) => calibrationCard(name, watch.calibration.sensors[i])));
  }

  function health(status, now_ns) {
    const body = byId('health').tBodies[0];
    if (!status) return replace(body, row(cell('No health has arrived yet.')));
    replace(body, ...[...SENSORS, 'temp'].map((name) => {
      const h = status.sensors[name].health;
      const since_s = h.since_ns > 0 && now_ns > h.since_ns ? (now_ns - h.since_ns) * 1e-9 : null;
      const words = (FAULT_WORDS[h.fault] || h.fault) + (h.state !== 'ok' && isNumber(since_s) ? ', for ' + duration(since_s) : '');
      return row(head(SENSOR_WORDS[name]), cell(chip(HEALTH_SIGNS[h.state] || ['none', h.state])), cell(words), cell(h.evidence > 0 ? fixed(h.evidence, 2) : UNKNOWN, 'n'));
    }));
  }

  function rests(state) {
    const list = [...state.rests].reverse().slice(0, 6);
    const going = list.length > 0 && list[0].going_on;
    say('rest-now', !state.watch.attitude ? '' : going ? 'It rests now, for ' + duration(list[0].seconds) + '.' : 'It moves now.');
    const body = byId('rests').tBodies[0];
    byId('rests').hidden = list.length === 0;
    replace(body, ...list.map((r) => row(cell(r.going_on ? 'now' : duration(state.t_s - r.start_s - r.seconds) + ' ago'), cell(duration(r.seconds), 'n'), cell(sideUp(r.up_body)))));
    const refused = state.status && state.status.last_refusal;
    say('rest-told', (state.status ? 'The daemon: ' + state.status.message + (refused ? '; last refused: ' + refused : '') + '.' : ''));
  }

  function coverage(state, up) {
    const { rested_s, share, missing } = state.coverage;
    sphere.draw(byId('sphere'), rested_s, state.rests, up);
    const words = Math.round(share * rested_s.length) + ' of ' + rested_s.length + ' directions have rested.' + (missing ? ' Missing: ' + missing + '.' : ' Nothing is missing.');
    say('coverage', words);
    byId('sphere').setAttribute('aria-label', words);
  }

  function latencyPicture(sets) {
    const W = 560, H = 150, BASE = 122, LEFT = 6;
    const edges = sets.flatMap(([, h]) => h.edges_us).filter((e) => e > 0);
    if (!edges.length) return element('p', {}, 'Nothing was measured yet.');
    const low = Math.floor(Math.log10(Math.min(...edges))), high = Math.max(low + 1, Math.ceil(Math.log10(Math.max(...edges))));
    const x = (us) => LEFT + ((W - 2 * LEFT) * (Math.log10(Math.max(us, 10 ** low)) - low)) / (high - low);
    const picture = svg('svg', { viewBox: `0 0 ${W} ${H}`, role: 'img', 'aria-label': 'Histogram of the latencies in the table below' });
    for (let p = low; p <= high; p++)
      picture.append(svg('line', { class: 'line', x1: x(10 ** p), x2: x(10 ** p), y1: 4, y2: BASE }),
        svg('text', { class: 'quiet', x: x(10 ** p), y: BASE + 18, 'text-anchor': p === low ? 'start' : p === high ? 'end' : 'middle' }, microseconds(10 ** p).replace(/\.0+ /, ' ')));
    const shares = sets.map(([name, h]) => { const all = h.counts.reduce((a, b) => a + b, 0) || 1; return [name, h, h.counts.map((n) => n / all)]; });
    const top = Math.max(1e-9, ...shares.flatMap(([, , s]) => s));
    for (const [name, h, s] of shares)
      s.forEach((share, i) => {
        if (share <= 0) return;
        const height = Math.max(1.5, ((BASE - 8) * share) / top), a = x(h.edges_us[i]), b = x(h.edges_us[i + 1]);
        picture.append(svg('rect', { class: name, x: a, y: BASE - height, width: Math.max(1, b - a - 1), height, 'fill-opacity': 0.65 }));
      });
    picture.append(svg('line', { class: 'line', x1: 0, x2: W, y1: BASE, y2: BASE }));
    return picture;
  }

  function latency(state) {
    const sets = [['daemon', state.latency.daemon], ['here', state.latency.here]].filter(([, h]) => h && h.counts.length);
    replace(byId('latency'), latencyPicture(sets));
    const line = (kind, name, l) => row(element('td', {}, element('span', { class: 'key ' + kind }), name), cell(l ? microseconds(l.p50) : UNKNOWN, 'n'), cell(l ? microseconds(l.p99) : UNKNOWN, 'n'), cell(l ? microseconds(l.max) : UNKNOWN, 'n'));
    replace(byId('percentiles').tBodies[0], line('daemon', 'inside the daemon', state.status && state.status.latency_us), line('here', 'to this page', state.watch.received ? state.watch.latency_us : null));
  }

  function counters(state) {
    const { watch, status } = state;
    const pairs = [['attitudes received here', watch.received], ['lost on the way here', watch.lost]];
    if (status) {
      const d = status.datagrams_refused;
      pairs.push(['source', status.source], ['samples', status.samples], ['rate', fixed(status.rate_hz, 1) + ' Hz' + (status.expected_rate_hz > 0 ? ' of ' + fixed(status.expected_rate_hz, 1) : '')],
        ['gaps', status.gaps + ', longest ' + fixed(status.longest_gap_s, 2) + ' s'], ['dropped inside', status.dropped], ['refused, not finite, clipped', [status.refused, status.not_finite, status.clipped].join(', ')],
        ['failed writes', status.write_failures], ['datagrams refused', `${d.malformed} malformed, ${d.off_host} from elsewhere, ${d.flooded} of a flood`], ['calibration', 'version ' + status.calibration_version]);
      say('missing', status.missing ? asSentence('The daemon does without: ' + status.missing) : 'The daemon lacks nothing: network, disk and rights are there.');
    }
    replace(byId('counters'), ...pairs.map(([name, value]) => element('div', {}, element('dt', {}, name), element('dd', {}, String(value)))));
  }

  return {
    draw: (state, up) => {
      calibration(state.watch);
      health(state.status, state.watch.attitude ? state.watch.attitude.t_ns : 0);
      rests(state);
      coverage(state, up);
      latency(state);
      counters(state);
    },
  };
})();
