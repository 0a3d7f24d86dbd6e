// SPDX-License-Identifier: MIT
// The page in the browser: mouse and keys to a body on the skin, strain and responses to pictures. The skin itself is
// session.cpp, compiled to WebAssembly.
'use strict';

const width = 240, height = 320, cells = width * height;
const spacing = 5e-5;           // m
const stepTime = 1 / 60;        // s
const shownTime = 4;            // s, of traces and spikes
const longest = 600 / stepTime; // steps of a recording
const seen = 0.2;               // s for which one sees a spike; responses of FA1 and FA2 fade to a tenth in it
const quantities = [            // by number of dermis::Quantity
  {name: 'strain', unit: ''}, {name: 'sa1', unit: ''}, {name: 'sa2', unit: 's'},
  {name: 'fa1', unit: '1/s', signed: true}, {name: 'fa2', unit: '1/s²', signed: true}];
const curvature = 5;
const colours = {SA1: '#0072b2', SA2: '#009e73', FA1: '#d55e00', FA2: '#aa4499'}; // those of host/lab/output/plot.py
const kinds = [{name: 'SA1', map: 1, dot: '#ffffff'}, {name: 'FA1', map: 3, dot: '#1c1c22'}, {name: 'FA2', map: 4, dot: '#1c1c22'}];
const radii = ['5', '2.5', '1']; // mm, with which a ball, a punch and an edge begin

const element = id => document.getElementById(id);

// 256 colours between equally distant ones, as the 32-bit numbers of an ImageData.
function palette(anchors) {
  return Uint32Array.from({length: 256}, (_, i) => {
    const at = i / 255 * (anchors.length - 1), low = Math.min(Math.floor(at), anchors.length - 2);
    const [a, b] = [anchors[low], anchors[low + 1]].map(c => [16, 8, 0].map(shift => c >> shift & 255));
    const [red, green, blue] = a.map((value, k) => Math.round(value + (at - low) * (b[k] - value)));
    return 255 << 24 | blue << 16 | green << 8 | red;
  });
}
const viridis = palette([0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c, 0x28ae80, 0x5ec962, 0xaddc30, 0xfde725]);
const blueToRed = palette([0x053061, 0x4393c3, 0xf7f7f7, 0xd6604d, 0x67001f]);

let wasm;
let settings;
let rows = [];   // of the recording
let spikes = []; // {time, fibre, kind, cell} of the last seconds
let fibres = [0, 0, 0];
let relief;      // of each cell: brightness of the resting skin, 155..255 of 256
let skinPixels;  // of each cell: its colour at rest
const body = {x: width * spacing / 2, y: height * spacing / 2, force: 0, pressed: false};
let ghost = true; // it presses until a visitor does

function check(refusal) {
  if (refusal) throw new Error(wasm.UTF8ToString(refusal));
}

function map(quantity) {
  const first = wasm._page_map(quantity); // which may let the memory grow, and then it is another buffer
  return new Float32Array(wasm.HEAPU8.buffer, first, cells);
}

function start() {
  settings = {
    ridge_period_m: element('surface').value === '1' ? element('ridges').valueAsNumber * 1e-3 : 0,
    modulus_pa: element('modulus').valueAsNumber * 1e3,
    shape: Number(element('shape').value),
    radius_m: element('radius').valueAsNumber * 1e-3,
    one_element: Number(element('material').value)};
  check(wasm._page_begin(settings.ridge_period_m, settings.modulus_pa, settings.shape, settings.radius_m, settings.one_element));
  rows = [];
  spikes = [];
  fibres = kinds.map((_, kind) => wasm._page_fibres(kind));
  body.force = 0;
  for (const q of quantities) {
    q.peak = q.greatest = 0;
    if (q.signed) q.shown = new Float32Array(cells);
  }
  const bend = map(curvature), sharpest = bend.reduce((most, c) => Math.max(most, Math.abs(c)), 1e-9);
  relief = Uint8Array.from(bend, c => 205 - 50 * c / sharpest);
  skinPixels = Uint32Array.from(relief, light => 255 << 24 | 0.78 * light << 16 | 0.86 * light << 8 | light);
}

// Mean and greatest value of a map. `peak`, the end of its colours, follows a response that fades, down to a fiftieth. Of
// FA1 and FA2, which answer for an instant, `shown` keeps what a screen can show.
function summarize(quantity, number) {
  const values = map(number), {shown} = quantity, fade = 0.1 ** (stepTime / seen);
  let sum = 0, most = 0;
  for (let i = 0; i < cells; ++i) {
    const size = Math.abs(values[i]);
    sum += values[i];
    if (size > most) most = size;
    if (shown) shown[i] = size > fade * Math.abs(shown[i]) ? values[i] : fade * shown[i];
  }
  quantity.mean = sum / cells;
  quantity.most = most;
  quantity.greatest = Math.max(most, quantity.greatest);
  quantity.peak = Math.max(most, 0.985 * quantity.peak, 0.02 * quantity.greatest);
}

function paint(number) {
  const quantity = quantities[number], {picture, context, signed, peak} = quantity, values = quantity.shown || map(number);
  const pixels = picture.pixels, scale = (signed ? 127.5 : 255) / (peak || 1), zero = signed ? 127.5 : 0;
  const colour = signed ? blueToRed : viridis;
  for (let i = 0; i < cells; ++i) pixels[i] = colour[Math.max(0, zero + scale * values[i]) | 0];
  shade(values, picture, peak || 1);
  context.putImageData(picture.image, 0, 0);
  drawSpikes(number, context);
  quantity.caption.textContent = peak ? `${signed ? '±' : '0 to '}${peak.toPrecision(2)} ${quantity.unit}` : '–';
}

// The last spikes, where their afferents end.
function drawSpikes(number, context) {
  const now = rows.length * stepTime;
  for (const {time, kind, cell} of spikes) {
    if (kind.map !== number || time < now - seen) continue;
    context.globalAlpha = 1 - Math.max(now - time, 0) / seen;
    context.fillStyle = kind.dot;
    context.fillRect(cell % width - 3, Math.floor(cell / width) - 3, 6, 6);
  }
  context.globalAlpha = 1;
}

// The strain in each picture, and by turns one half of all else, because many screens are drawn by a processor.
function draw() {
  paint(0);
  drawBody();
  if (++drawn % 2) {
    paint(1);
    paint(2);
    drawTraces();
  } else {
    paint(3);
    paint(4);
    drawRaster();
  }
  if (drawn % 30 === 0) say();
}

// Lays the picture of a map over the skin, whose valleys are dark and whose ridges light: skin shows where the
// map is below a fifth of its peak.
function shade(values, {pixels}, peak) {
  for (let i = 0; i < cells; ++i) {
    const cover = Math.min(5 * Math.abs(values[i]) / peak, 1), skin = skinPixels[i], colour = pixels[i];
    if (cover < 1 / 256) {
      pixels[i] = skin;
      continue;
    }
    const over = cover * (0.2 + relief[i] / 320), under = 1 - cover;
    pixels[i] = 255 << 24 | over * (colour >> 16 & 255) + under * (skin >> 16 & 255) << 16
      | over * (colour >> 8 & 255) + under * (skin >> 8 & 255) << 8 | over * (colour & 255) + under * (skin & 255);
  }
}

// The outline of what touches the skin: a rectangle of the edge's length, or a circle.
function drawBody() {
  const context = quantities[0].context, area = wasm._page_pressed() / spacing ** 2, long = 8e-3 / spacing;
  const [x, y] = [body.x / spacing, body.y / spacing], from = Math.max(x - long / 2, 0), to = Math.min(x + long / 2, width);
  const high = Math.max(area / (to - from), 2);
  context.strokeStyle = body.pressed ? '#ffffff' : '#1c1c22';
  context.lineWidth = 1.2;
  context.beginPath();
  if (settings.shape === 2) context.rect(from, y - high / 2, to - from, high);
  else context.arc(x, y, Math.max(Math.sqrt(area / Math.PI), 3), 0, 2 * Math.PI);
  context.stroke();
}

// A finger that presses for two seconds of three, and wanders meanwhile.
function haunt() {
  const time = rows.length * stepTime, way = 0.4 * Math.PI * time;
  body.pressed = time % 3 > 0.3 && time % 3 < 2.3;
  move((0.5 + 0.22 * Math.sin(way)) * width * spacing, (0.5 + 0.25 * Math.cos(0.7 * way)) * height * spacing);
}

function step() {
  if (ghost) haunt();
  const asked = body.pressed ? element('force').valueAsNumber : 0; // reached in 60 ms
  const change = element('force').valueAsNumber * stepTime / 0.06;
  body.force = asked > body.force ? Math.min(asked, body.force + change) : Math.max(asked, body.force - change);
  check(wasm._page_step(body.x, body.y, body.force));
  const time = rows.length * stepTime, fired = [0, 0, 0];
  for (let i = 0; i < wasm._page_spikes(); ++i) {
    const fibre = wasm._page_spike_fibre(i);
    const kind = fibre < fibres[0] ? 0 : fibre < fibres[0] + fibres[1] ? 1 : 2;
    const cell = wasm._page_ending(kind, fibre - [0, fibres[0], fibres[0] + fibres[1]][kind]);
    spikes.push({time: time + wasm._page_spike_time(i), fibre, kind: kinds[kind], cell});
    ++fired[kind];
  }
  quantities.forEach(summarize);
  rows.push([time + stepTime, body.x, body.y, body.force, ...quantities.flatMap(q => [q.mean, q.most]), ...fired]);
}

// A canvas whose pixels are those of the screen, empty.
function cleared(id) {
  const canvas = element(id), context = canvas.getContext('2d'), ratio = window.devicePixelRatio || 1;
  const wide = Math.round(canvas.clientWidth * ratio), high = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  context.font = '12px system-ui, sans-serif';
  return [context, canvas.clientWidth, canvas.clientHeight];
}

const left = 70; // pixels beside the plots, for their names

function drawTraces() {
  const [context, wide, high] = cleared('traces'), shown = rows.slice(-shownTime / stepTime);
  quantities.slice(1).forEach((q, k) => {
    const column = 4 + 2 * (k + 1), top = k * high / 4, room = high / 4 - 8;
    let low = 0, most = 1e-12;
    for (const row of shown) [low, most] = [Math.min(low, row[column]), Math.max(most, row[column])];
    context.fillStyle = colours[q.name.toUpperCase()];
    context.fillText(q.name.toUpperCase(), 4, top + 16);
    context.fillStyle = '#4a4a52';
    context.fillText(most > 1e-12 ? most.toPrecision(2) + ' ' + q.unit : '', 4, top + 31);
    context.strokeStyle = '#c8c8d0';
    context.beginPath();
    const zero = top + 4 + room * most / (most - low);
    context.moveTo(left, zero);
    context.lineTo(wide, zero);
    context.stroke();
    context.strokeStyle = colours[q.name.toUpperCase()];
    context.lineWidth = 1.5;
    context.beginPath();
    shown.forEach((row, i) => context.lineTo(wide - (shown.length - 1 - i) * (wide - left) * stepTime / shownTime,
      top + 4 + room * (most - row[column]) / (most - low)));
    context.stroke();
  });
}

function drawRaster() {
  const [context, wide, high] = cleared('raster'), now = rows.length * stepTime;
  const total = fibres[0] + fibres[1] + fibres[2];
  spikes = spikes.filter(spike => spike.time > now - shownTime);
  let first = 0;
  kinds.forEach((kind, k) => {
    const from = first;
    context.fillStyle = colours[kind.name];
    context.beginPath();
    for (const {time, fibre, kind: {name}} of spikes)
      if (name === kind.name) context.rect(wide - (now - time) * (wide - left) / shownTime, fibre * high / total, 1.5, 1.5);
    context.fill();
    context.fillText(`${kind.name}, ${fibres[k]}`, 4, Math.min((from + 0.5 * fibres[k]) * high / total + 4, high - 3));
    first += fibres[k];
  });
}

function say() {
  const place = `${(body.x * 1e3).toFixed(1)}, ${(body.y * 1e3).toFixed(1)} mm`;
  element('status').textContent = ghost ? 'A finger presses by itself until you press.' : body.force > 0
    ? `${body.force.toFixed(2)} N press at ${place}; the greatest strain is ${quantities[0].most.toFixed(2)}.`
    : `The body is above ${place} and does not press.`;
  element('steps').textContent = rows.length;
  element('hash').textContent = wasm.UTF8ToString(wasm._page_hash());
}

let last = 0, waiting = 0, drawn = 0, paused = false;
const speed = {from: 0, frames: 0, steps: 0, seconds: 0};

function measure(now) {
  ++speed.frames;
  if (now - speed.from < 1000) return;
  const each = (1e3 * speed.seconds / speed.steps).toFixed(1);
  if (speed.steps > 0) element('speed').textContent = `${Math.round(1e3 * speed.frames / (now - speed.from))} pictures a second; `
    + `a step with its pictures takes ${each} ms.`;
  Object.assign(speed, {from: now, frames: 0, steps: 0, seconds: 0});
}

function frame(now) {
  requestAnimationFrame(frame);
  waiting = Math.min(waiting + (now - last) / 1e3, 2 * stepTime);
  last = now;
  measure(now);
  if (paused) return;
  try {
    const begin = performance.now();
    for (; waiting > 0.9 * stepTime && rows.length < longest; waiting -= stepTime) {
      step();
      ++speed.steps;
    }
    draw();
    speed.seconds += (performance.now() - begin) / 1e3;
    if (ghost && rows.length >= longest) start();
    if (rows.length >= longest) throw new Error('The recording has ten minutes and is full. Start again to press on.');
  } catch (error) {
    element('error').textContent = error.message;
    pause(true);
  }
}

function pause(on) {
  paused = on;
  element('pause').setAttribute('aria-pressed', String(on));
  say();
}

function recording() {
  const names = ['time_s', 'x_m', 'y_m', 'force_n',
    ...quantities.flatMap(({name}) => [`${name}_mean`, `${name}_greatest`]), ...kinds.map(k => `spikes_${k.name.toLowerCase()}`)];
  const chosen = Object.entries(settings).map(([key, value]) => `${key}=${value}`);
  return `# dermis page, ${chosen.join(', ')}\n${names.join(',')}\n${rows.map(row => row.join(',')).join('\n')}\n`;
}

function save() {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(new Blob([recording()], {type: 'text/csv'}));
  link.download = 'dermis-recording.csv';
  link.click();
  URL.revokeObjectURL(link.href);
}

function move(x, y) {
  body.x = Math.min(Math.max(x, 0), (width - 0.5) * spacing);
  body.y = Math.min(Math.max(y, 0), (height - 0.5) * spacing);
}

// A visitor presses, or comes by keyboard: the ghost never does again.
function take(pressed) {
  ghost = false;
  body.pressed = pressed;
}

function listenToPointer(skin) {
  const follow = event => move(event.offsetX / skin.clientWidth * width * spacing,
    event.offsetY / skin.clientHeight * height * spacing);
  skin.addEventListener('pointerdown', event => {
    skin.setPointerCapture(event.pointerId);
    take(true);
    follow(event);
  });
  skin.addEventListener('pointermove', event => { if (!ghost) follow(event); });
  for (const end of ['pointerup', 'pointercancel']) skin.addEventListener(end, () => take(false));
}

function listenToKeys(skin) {
  const ways = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
  skin.addEventListener('keydown', event => {
    const way = ways[event.key], length = event.shiftKey ? spacing : 5 * spacing;
    if (!way && event.key !== ' ') return;
    take(event.key === ' ' || body.pressed && !ghost);
    if (way) move(body.x + way[0] * length, body.y + way[1] * length);
    event.preventDefault();
  });
  skin.addEventListener('keyup', event => { if (event.key === ' ') take(false); });
  skin.addEventListener('blur', () => { if (!ghost) take(false); });
}

function showSettings() {
  const shown = {force: ['N', 2], radius: ['mm', 1], ridges: ['mm', 2], modulus: ['kPa', 0]};
  for (const [id, [unit, digits]] of Object.entries(shown))
    element(`${id}-shown`).textContent = `${element(id).valueAsNumber.toFixed(digits)} ${unit}`;
}

function again() {
  element('error').textContent = '';
  try {
    start();
    pause(false);
  } catch (error) {
    element('error').textContent = error.message;
  }
}

// The bytes of dermis.wasm, which wasm.js has as text: compressed, because it is a third of the size.
async function bytesOfWasm() {
  const compressed = Uint8Array.from(atob(dermisWasm), c => c.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

async function main() {
  wasm = await loadDermis({wasmBinary: await bytesOfWasm()});
  for (const q of quantities) {
    const canvas = element(q.name === 'strain' ? 'skin' : q.name);
    q.context = canvas.getContext('2d');
    const image = q.context.createImageData(width, height);
    q.picture = {image, bytes: image.data, pixels: new Uint32Array(image.data.buffer)};
    q.caption = element(`scale-${q.name}`);
    q.caption.previousElementSibling.style.color = colours[q.name.toUpperCase()];
  }
  listenToPointer(element('skin'));
  listenToKeys(element('skin'));
  showSettings();
  element('shape').addEventListener('input', event => { element('radius').value = radii[event.target.value]; });
  element('settings').addEventListener('input', showSettings);
  element('settings').addEventListener('change', event => { if (event.target.id !== 'force') again(); });
  element('restart').addEventListener('click', again);
  element('pause').addEventListener('click', () => pause(!paused));
  element('save').addEventListener('click', save);
  start();
  requestAnimationFrame(frame);
}

main().catch(error => { element('error').textContent = `This browser cannot run the page: ${error.message}`; });
