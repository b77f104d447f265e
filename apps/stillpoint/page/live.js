// Takes the events of `stillpoint page` and draws them: what moves at each event, the rest once a second.
(() => {
  const SILENCE_MS = 2000, SLOW_MS = 1000;
  let source = null, state = null, lastEvent = 0, lastSlow = -Infinity, lost = '', isDue = false;

  function banner(word, why, kind) {
    const box = byId('banner');
    box.hidden = word === '';
    box.className = kind || '';
    say('banner-word', word);
    say('banner-why', why);
    document.body.classList.toggle('old', word !== '' && kind !== 'waiting');
    document.title = (word ? word + ' · ' : '') + 'Stillpoint, live';
  }

  function alarms() {
    if (lost) return banner('CONNECTION LOST', lost + (state ? ' What is shown is the last that came.' : ''));
    if (!state) return banner('', '');
    if (state.freshness === 'waiting') return banner('WAITING', 'No attitude has come yet: ' + asSentence(state.why), 'waiting');
    if (state.freshness === 'stale') return banner('STALE', 'The attitude is out of date: ' + asSentence(state.why) + ' What is shown is the last that came.');
    banner('', '');
  }

  function header() {
    const { watch, status, freshness } = state;
    const a = watch.attitude;
    const word = freshness === 'stale' ? 'stale' : a ? (a.status === 'ok' && status ? status.status : a.status) : 'initializing';
    byId('head').className = 'verdict ' + word;
    say('who', ['Stillpoint, live', status && status.sensor_id ? 'sensor ' + status.sensor_id : ''].filter(Boolean).join(' · '));
    const sentence = freshness === 'waiting' ? 'Waiting for a daemon.' : (STATUS_WORDS[word] || word) + (a && word !== 'initializing' && word !== 'stale' ? ' ' + (HEADING_WORDS[a.heading_reference] || a.heading_reference) : '');
    say('sentence', sentence);
    const facts = [];
    if (a && freshness === 'live') facts.push('status: ' + word, a.at_rest ? 'at rest' : 'moving', fixed(watch.rate_hz, 0) + ' attitudes a second');
    if (a && isNumber(a.temperature_degC)) facts.push(fixed(a.temperature_degC, 1) + ' °C');
    if (status) facts.push('running for ' + duration(status.uptime_s), status.source);
    say('facts', facts.join(' · '));
  }

  const upInBody = ([x, y, z, w]) => [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
  const isKnown = (a) => a && a.status !== 'initializing' && a.orientation_xyzw.every(isNumber);

  function drawFast() {
    const a = state.watch.attitude;
    if (isKnown(a)) {
      const [roll, pitch, yaw] = a.roll_pitch_yaw_rad;
      body.draw(byId('body'), a.orientation_xyzw, yaw, a.sigma_rpy_rad[2], a.heading_reference === 'relative');
      [['roll', 'x'], ['pitch', 'y'], ['yaw', 'z']].forEach(([name, axis], i) => {
        say(name, fixed(a.roll_pitch_yaw_rad[i] * DEG, 1));
        say(name + '-sd', '± ' + fixed(a.sigma_rpy_rad[i] * DEG, 2));
        say('rate-' + axis, fixed(a.rate_radps[i] * DEG, 1));
      });
      say('facing', facing(yaw, a.heading_reference));
      say('body-how', (a.heading_reference === 'relative' ? 'Seen from above and behind the start. ' : 'Seen from the south and above. ') + 'The wedge on the ground is the heading, 3 sigma either way.');
    } else {
      body.draw(byId('body'), null, null, null, true);
    }
    curves.draw();
  }

  function drawSlow() {
    const a = state.watch.attitude;
    panels.draw(state, isKnown(a) ? upInBody(a.orientation_xyzw) : null);
    if (isKnown(a)) byId('body').setAttribute('aria-label', 'The body: roll ' + fixed(a.roll_pitch_yaw_rad[0] * DEG, 0) + ', pitch ' + fixed(a.roll_pitch_yaw_rad[1] * DEG, 0) + ', yaw ' + fixed(a.roll_pitch_yaw_rad[2] * DEG, 0) + ' degrees');
  }

  function draw(now) {
    isDue = false;
    if (!state) return;
    drawFast();
    if (now - lastSlow >= SLOW_MS) {
      lastSlow = now;
      header();
      drawSlow();
    }
  }

  function take(event) {
    const before = state;
    state = JSON.parse(event.data);
    lastEvent = performance.now();
    lost = '';
    const a = state.watch.attitude;
    const isFresh = state.freshness === 'live' && isKnown(a);
    curves.add(state.t_s, isFresh ? a.roll_pitch_yaw_rad : null, isFresh ? a.sigma_rpy_rad : null, isFresh && a.at_rest);
    if (!before || before.freshness !== state.freshness) lastSlow = -Infinity;
    alarms();
    if (!isDue) { isDue = true; requestAnimationFrame(draw); }
  }

  // After the server has refused, the browser does not try again by itself.
  async function refused() {
    source.close();
    source = null;
    let why = 'Nothing answers at this address; is `stillpoint page` still running? It is tried again every 3 s.';
    try {
      if ((await fetch('/state')).ok) why = 'This page is open too often: the server feeds eight at once. Close one; it is tried again every 3 s.';
    } catch (e) { /* nothing answers, as it is said */ }
    lost = why;
    alarms();
    setTimeout(connect, 3000);
  }

  function connect() {
    source = new EventSource('/events');
    source.addEventListener('history', (event) => curves.begin(JSON.parse(event.data)));
    source.onmessage = take;
    source.onerror = () => {
      if (source.readyState === EventSource.CLOSED) return refused();
      lost = 'Nothing comes from `stillpoint page` any more; is it still running? It is tried again every second.';
      alarms();
    };
  }

  setInterval(() => {
    if (source && !lost && lastEvent > 0 && performance.now() - lastEvent > SILENCE_MS) lost = 'Nothing came from `stillpoint page` for two seconds.';
    alarms();
  }, 500);
  window.addEventListener('resize', () => { curves.resize(); lastSlow = -Infinity; if (state) requestAnimationFrame(draw); });
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { readColors(); lastSlow = -Infinity; if (state) requestAnimationFrame(draw); });
  connect();
})();
