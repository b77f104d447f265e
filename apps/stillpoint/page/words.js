'use strict';
// What the numbers are called. Every state has a word and a sign, so that nothing hangs on a colour alone.
const DEG = 180 / Math.PI;
const UNKNOWN = '–';

const isNumber = (x) => typeof x === 'number' && Number.isFinite(x);
const fixed = (x, digits) => (isNumber(x) ? x.toFixed(digits).replace('-', '−') : UNKNOWN);
// Three digits that say something, whatever the size.
const short = (x) => (isNumber(x) ? fixed(x, Math.max(0, Math.min(5, 2 - Math.floor(Math.log10(Math.max(1e-9, Math.abs(x))))))) : UNKNOWN);
const microseconds = (x) => (!isNumber(x) ? UNKNOWN : x < 1000 ? short(x) + ' µs' : x < 1e6 ? short(x / 1000) + ' ms' : short(x / 1e6) + ' s');
const duration = (s) => (!isNumber(s) ? UNKNOWN : s < 120 ? fixed(s, 0) + ' s' : s < 7200 ? fixed(s / 60, 0) + ' min' : fixed(s / 3600, 1) + ' h');

const asSentence = (text) => (/[.?!]$/.test(text) ? text : text + '.');

const STATUS_WORDS = {
  initializing: 'No attitude yet: the filter is still looking for up and for its heading.',
  ok: 'The attitude is known.',
  degraded: 'The attitude is known less well than usual: a sensor is disturbed, missing or late.',
  stale: 'The attitude is out of date. What is shown is the last one.',
};
const HEADING_WORDS = {
  relative: 'Its heading counts from the start and drifts.',
  magnetic: 'Its heading is magnetic.',
  true: 'Its heading is from true north.',
  disturbed: 'The magnetic field is disturbed here, so the gyroscope carries the heading.',
};
const SENSOR_WORDS = { acc: 'Accelerometer', gyr: 'Gyroscope', mag: 'Magnetometer', temp: 'Thermometer' };
const HEALTH_SIGNS = { ok: ['good', '✓ ok'], suspect: ['warn', '! suspect'], faulty: ['bad', '✕ faulty'], absent: ['none', '○ absent'] };
const FAULT_WORDS = {
  none: 'nothing against it', absent: 'no readings', stuck: 'readings repeat to the last bit', zero: 'readings are zero', clipped: 'readings sit at the full scale',
  spikes: 'single readings that no motion gives', noisy: 'far noisier than it was', offset: 'its offset has jumped', scale: 'its scale contradicts the other sensors',
  axes: 'axes swapped, mirrored or turned', late: 'readings come or are stamped too late', repeated: 'readings come twice', clock: 'its clock jumps, stands or runs backwards',
  units: 'readings cannot be in the stated unit', disturbed: 'the field is not the reference field', inconsistent: 'contradicts the other sensors',
};
const CALIBRATION_WORDS = {
  factory: ['none', '○ factory', 'Nothing is learnt yet: the values of the configuration serve.'],
  ok: ['good', '✓ learnt', ''],
  too_few_windows: ['warn', '… too few rests', 'Rest windows are missing: lay it down in further attitudes.'],
  not_observable: ['warn', '… one-sided', 'The rests lie in one plane or around one axis: lay it on other sides.'],
  not_positive_definite: ['bad', '✕ no ellipsoid', 'The readings form no ellipsoid: something disturbs them.'],
  clipped: ['bad', '✕ clipped', 'The readings sit at the limit of the sensor.'],
  stuck: ['bad', '✕ stuck', 'The readings do not change at all.'],
  replaced: ['warn', '! another sensor', 'The evidence contradicts what was learnt; it is learnt anew.'],
};
const SIDES = ['front up', 'back up', 'left side up', 'right side up', 'top up', 'upside down'];

function sideUp(up) {
  const axis = [0, 1, 2].reduce((best, i) => (Math.abs(up[i]) > Math.abs(up[best]) ? i : best), 0);
  const tilt = Math.acos(Math.min(1, Math.abs(up[axis]))) * DEG;
  return SIDES[2 * axis + (up[axis] < 0 ? 1 : 0)] + (tilt < 5 ? '' : ', tilted ' + fixed(tilt, 0) + '°');
}

// Yaw 0 is east and counter-clockwise is positive; a compass starts at north and runs clockwise.
function facing(yaw, reference) {
  const heading = (((90 - yaw * DEG) % 360) + 360) % 360;
  if (reference === 'relative') return 'Turned ' + fixed(Math.abs(yaw * DEG), 0) + '° to the ' + (yaw >= 0 ? 'left' : 'right') + ' of the first heading.';
  const names = ['north', 'north-east', 'east', 'south-east', 'south', 'south-west', 'west', 'north-west'];
  return 'The front faces ' + names[Math.round(heading / 45) % 8] + ', heading ' + fixed(heading, 0) + '°' + (reference === 'true' ? ' true.' : ' magnetic.');
}

const byId = (id) => document.getElementById(id);
const say = (id, text) => { const e = byId(id); if (e.textContent !== text) e.textContent = text; };
const colors = {};
// Read once and at each change of the scheme, not at every frame.
function readColors() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['ink', 'quiet', 'page', 'card', 'rule', 'before', 'after', 'accent', 'noise', 'held', 'good', 'warn', 'bad']) colors[name] = style.getPropertyValue('--' + name).trim();
}
readColors();

// An element with attributes and children; text is never parsed as HTML, whatever a sensor is called.
function element(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) e.setAttribute(name, value);
  e.append(...children);
  return e;
}
function svg(tag, attributes, ...children) {
  const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes || {})) e.setAttribute(name, value);
  e.append(...children);
  return e;
}
const chip = ([kind, text]) => element('span', { class: 'chip ' + kind }, text);

// A canvas sized to its place on the screen, cleared, in CSS pixels.
function drawing(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
