// Two to six layers of one frame in one place: wiped, flipped, side by side in step, or subtracted. The layers are numbers;
// what they look like is chosen here. Place and zoom stay when the layers change, so that techniques, frames and runs can be
// compared at one spot.
import {palette} from './api.js';
import {legend} from './colour_scales.js';
import {announce, field, h, replace} from './dom.js';
import {count, fixed, missing, scientific, shortCount, significant} from './format.js';
import {toneNames} from './pixel_math.js';
import {ask, bitmap} from './pixels.js';

const maxScale = 128;
const gridFrom = 12;      // CSS pixels per image pixel from which pixel borders are drawn
const valuesFrom = 56;    // and their values
const grab = 14;          // how near to the line a pointer takes hold of it
const zoomSteps = [1, 2, 4, 8, 16, 32, 64];
export const maxLayers = 6;

const modes = {wipe: ['Wipe', 'w'], flip: ['Flip', 'f'], side: ['Side by side', 's'], difference: ['Difference', 'd']};
const measures = {largest: 'largest channel', luminance: 'luminance', mean: 'mean of channels', r: 'red', g: 'green', b: 'blue', flip: 'FLIP'};
const signless = ['largest', 'flip'];
const channels = {all: 'colour', r: 'red', g: 'green', b: 'blue', luminance: 'luminance'};

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const isMap = (layer) => layer?.kind === 'map';

/** A value as text: counts whole, bytes as shares of 1, others to four digits. */
export function valueText(value, type) {
  if (!Number.isFinite(value)) return String(value);
  if (type === 'uint') return count(value);
  if (type === 'byte') return fixed(value, 3);
  return value !== 0 && Math.abs(value) < 1e-3 ? scientific(value) : significant(value, 4);
}

export class CompareView {
  #canvas = h('canvas.view-canvas', {tabindex: 0, role: 'application', 'aria-label': 'Layers of the frame'});
  #labels = h('div.view-labels', {});
  #handle = h('div.wipe-handle', {'aria-hidden': true}, h('span', {}, '⇔'));
  #minimap = h('canvas.minimap', {width: 160, height: 90, 'aria-hidden': true});
  #magnifier = h('canvas.magnifier', {width: 187, height: 187, 'aria-hidden': true, hidden: true});
  #message = h('p.view-message', {role: 'status', hidden: true});
  #wipe = h('input', {type: 'range', min: 0, max: 1000, value: 500, 'aria-label': 'Position of the dividing line', oninput: () => this.#setShare(this.#wipe.value / 1000)});
  #readout = h('div.readout', {}, 'Point at a pixel for its values.');
  #scaleText = h('span.quiet.scale', {});
  #modeButtons = h('div.chips', {role: 'group', 'aria-label': 'How layers are compared'});
  #sides = h('div.view-sides', {});
  #lookPanel = h('div.look', {});
  #legends = h('div.legends', {});
  #boxPanel = h('section.box-panel', {'aria-live': 'polite'});
  #worstPanel = h('section.worst-panel', {});
  #onChange;
  #layers = [];
  #state = {mode: 'wipe', a: 0, b: 1, share: 0.5, scale: 0, cx: null, cy: null, box: null, measure: 'largest', signed: false, gain: 4,
    exposure: 0, tone: 'none', channel: 'all', falseColour: false, log: false, palette: '', low: null, high: null, magnify: false};
  #shown = [];          // what is on the canvas: [{layers, bitmap, label, operation}]
  #size = null;         // {width, height} of the images
  #pointer = null;      // {x, y} where it was last over the canvas
  #controlsFor = '';    // what the controls were drawn for
  #busy = false;
  #again = false;
  #settled = Promise.resolve();
  #reading = false;
  #region = null;       // values drawn into large pixels: {key, rows, x, y}
  #closed = false;
  #resize = new ResizeObserver(() => this.#draw());

  /** `onChange(state)` is told whatever the user changes, for the address. */
  constructor(onChange = () => {}) {
    this.#onChange = onChange;
    const zoomButton = (label, act, title) => h('button.plain', {type: 'button', title, 'aria-label': `${label} ${title}`, onclick: act}, label);
    this.element = h('div.view', {'aria-busy': 'true'},
      this.#modeButtons, this.#sides,
      h('div.view-stage', {}, this.#canvas, this.#handle, this.#labels, this.#minimap, this.#magnifier, this.#message),
      h('div.view-controls', {},
        h('label.wipe', {}, h('span', {}, 'Wipe'), this.#wipe),
        h('span.zoom', {}, zoomButton('Fit', () => this.#zoomTo(0), 'Whole image'), zoomButton('−', () => this.#zoomBy(1 / 1.5), 'Zoom out'),
          zoomButton('+', () => this.#zoomBy(1.5), 'Zoom in'), zoomButton('1×', () => this.#zoomTo(1), 'One pixel each'),
          zoomButton('8×', () => this.#zoomTo(8), 'Eight times'), zoomButton('64×', () => this.#zoomTo(64), 'Values in the pixels')),
        this.#scaleText,
        h('button', {type: 'button', onclick: () => this.#boxHere()}, 'Box'),
        h('button', {type: 'button', onclick: () => this.#toggleMagnifier()}, 'Magnifier'),
        h('button', {type: 'button', onclick: () => this.showWorst()}, 'Worst places')),
      this.#readout, this.#legends, this.#lookPanel, this.#boxPanel, this.#worstPanel);
    this.#listen();
    this.#resize.observe(this.#canvas);
  }

  close() {
    this.#closed = true;
    this.#resize.disconnect();
  }

  get state() {
    return {...this.#state};
  }

  get layers() {
    return this.#layers;
  }

  /** Resolves when what was asked for last is on the screen. */
  get settled() {
    return this.#settled;
  }

  /**
   * Shows these layers, 1 to 6: {key, label, url, kind: display|linear|map, scale (of maps), reference (a layer that it is an error
   * to)}. `state` changes what it names.
   */
  setLayers(layers, state = {}) {
    this.#layers = layers.slice(0, maxLayers);
    Object.assign(this.#state, state);
    const last = Math.max(0, this.#layers.length - 1);
    this.#state.a = clamp(this.#state.a, 0, last);
    this.#state.b = clamp(this.#state.b, 0, last);
    this.#refresh();
    return this.#settled;
  }

  /** What the address says, before there are layers. */
  restore(state) {
    Object.assign(this.#state, state);
  }

  /** Changes the state, draws it and tells. */
  change(state) {
    Object.assign(this.#state, state);
    this.#onChange(this.state);
    this.#refresh();
  }

  // What is shown ------------------------------------------------------------------------------------------------

  #lookOf(layer) {
    const {exposure, tone, channel, falseColour, log, palette: named, low, high} = this.#state;
    const numbers = isMap(layer) || falseColour;
    if (!numbers) return layer.kind === 'linear' || exposure !== 0 || tone !== 'none' || channel !== 'all' ? {exposure, tone, channel} : {};
    const scale = this.#scaleOf(layer);
    return {palette: scale.map === 'grey' ? null : palette(scale.map), low: scale.low, high: scale.maximum, log, channel};
  }

  // The scale numbers are coloured by: the layer's own where nothing else was chosen.
  #scaleOf(layer) {
    const {palette: named, low, high, log} = this.#state;
    const own = layer.scale ?? {map: 'viridis', maximum: 1, discrete: false, description: `${layer.label}: luminance`, unit: ''};
    const changed = low !== null || high !== null || log;
    return {...own, map: named || own.map, low: low ?? 0, maximum: high ?? own.maximum, log, discrete: own.discrete && !changed};
  }

  #wanted(layers = this.#layers) {
    const {mode, a, b, measure, signed, gain} = this.#state;
    const plain = (layer) => ({layers: [layer], label: layer.label, operation: 'colour',
      request: {layer: {url: layer.url, kind: layer.kind}, look: this.#lookOf(layer)}});
    if (layers.length < 2) return layers.map(plain);
    const [first, second] = [layers[a], layers[b]];
    if (mode === 'side') return layers.map(plain);
    if (mode === 'flip') return [plain(first)];
    if (mode === 'wipe') return a === b ? [plain(first)] : [plain(first), plain(second)];
    const short = ({url, kind}) => ({url, kind});
    const withSign = signed && !signless.includes(measure);
    return [{layers: [first, second], operation: 'difference',
      label: `${first.label} − ${second.label}: ${isMap(first) ? 'numbers' : measures[measure]}${withSign ? ', signed' : ''}, ×${gain}`,
      request: {a: short(first), b: short(second), measure, signed: withSign, gain, palette: palette('magma')}}];
  }

  // One at a time: while one is on its way, only the last of what is asked for meanwhile follows.
  #refresh() {
    this.#drawControls();
    if (this.#busy) {
      this.#again = true;
      return;
    }
    this.#busy = true;
    this.#settled = this.#load();
  }

  async #load() {
    do {
      this.#again = false;
      this.element.setAttribute('aria-busy', 'true');
      const wanted = this.#wanted();
      try {
        const pictures = await Promise.all(wanted.map(({operation, request}) => bitmap(operation, request)));
        this.#shown = wanted.map((entry, i) => ({...entry, bitmap: pictures[i].bitmap}));
        this.#size = pictures[0] && {width: pictures[0].width, height: pictures[0].height};
        this.#say('');
        this.element.dataset.shown = wanted.map(({layers}) => layers.map(({url}) => url).join('-')).join(' ');  // for tests
        this.element.dataset.keys = wanted.map(({layers}) => layers.map(({key}) => key).join('-')).join(' ');
      } catch (error) {
        this.#shown = [];  // nothing, rather than what was there before under another's name
        this.#say(`This can't be shown: ${error.message}`);
      }
      this.#draw();
    } while (this.#again && !this.#closed);
    this.#busy = false;
    this.element.setAttribute('aria-busy', 'false');
    this.#read();
    this.#measureBox();
    this.#readAhead();
  }

  /** Fetches what these layers, as many as are shown, will look like: the next frame's. */
  readAhead(layers) {
    if (layers.length !== this.#layers.length) return;
    for (const {operation, request} of this.#wanted(layers)) bitmap(operation, request).catch(() => {});
  }

  // The other layers, so that flipping to them is at once.
  #readAhead() {
    if (this.#state.mode !== 'flip') return;
    for (const layer of this.#layers) bitmap('colour', {layer: {url: layer.url, kind: layer.kind}, look: this.#lookOf(layer)}).catch(() => {});
  }

  #say(text) {
    this.#message.textContent = text;
    this.#message.hidden = text === '';
  }

  // Geometry -----------------------------------------------------------------------------------------------------

  #box() {
    const box = this.#canvas.getBoundingClientRect();
    return {width: Math.max(1, box.width), height: Math.max(1, box.height)};
  }

  // Parts of the canvas, each of which shows whole layers at the same place and zoom.
  #cells() {
    const {width, height} = this.#box();
    const number = this.#state.mode === 'side' ? this.#shown.length : 1;
    if (number <= 1 || !this.#size) return [{x: 0, y: 0, width, height}];
    let best = null;
    for (let columns = 1; columns <= number; ++columns) {
      const rows = Math.ceil(number / columns);
      const fit = Math.min(width / columns / this.#size.width, height / rows / this.#size.height);
      if (!best || fit > best.fit) best = {columns, rows, fit};
    }
    const [w, t] = [width / best.columns, height / best.rows];
    return this.#shown.map((_, i) => ({x: (i % best.columns) * w, y: Math.floor(i / best.columns) * t, width: w, height: t}));
  }

  #fitScale(cell = this.#cells()[0]) {
    return Math.min(cell.width / this.#size.width, cell.height / this.#size.height);
  }

  // Scale, and the image's top left corner in CSS pixels within the cell.
  #placement(cell = this.#cells()[0]) {
    const {scale: chosen, cx, cy} = this.#state;
    const scale = chosen > 0 ? chosen : this.#fitScale(cell);
    const x = chosen > 0 ? cx : this.#size.width / 2;
    const y = chosen > 0 ? cy : this.#size.height / 2;
    return {scale, x: cell.width / 2 - x * scale, y: cell.height / 2 - y * scale};
  }

  /** Brings an image point into the middle. */
  goTo(x, y, scale) {
    if (!this.#size) return;
    Object.assign(this.#state, {scale: clamp(scale, Math.min(this.#fitScale(), 1) / 2, maxScale), cx: clamp(x, 0, this.#size.width), cy: clamp(y, 0, this.#size.height)});
    this.#moved();
  }

  // Zooms so that the point under (x, y) of the cell, by default the middle, stays where it is. 0: the whole image.
  #zoomTo(scale, cell = this.#cells()[0], x = cell.width / 2, y = cell.height / 2) {
    if (!this.#size) return;
    if (scale === 0) {
      Object.assign(this.#state, {scale: 0, cx: null, cy: null});
      return this.#moved();
    }
    const place = this.#placement(cell);
    const point = {x: (x - place.x) / place.scale, y: (y - place.y) / place.scale};
    const next = clamp(scale, Math.min(this.#fitScale(cell), 1) / 2, maxScale);
    this.goTo(point.x + (cell.width / 2 - x) / next, point.y + (cell.height / 2 - y) / next, next);
  }

  #zoomBy(factor) {
    if (this.#size) this.#zoomTo(this.#placement().scale * factor);
  }

  #pan(dx, dy) {
    if (!this.#size) return;
    const cell = this.#cells()[0];
    const {scale, x, y} = this.#placement(cell);
    this.goTo((cell.width / 2 - x - dx) / scale, (cell.height / 2 - y - dy) / scale, scale);
  }

  #moved() {
    this.#draw();
    this.#read();
    this.#onChange(this.state);
  }

  #setShare(share) {
    this.#state.share = clamp(share, 0, 1);
    this.#draw();
    this.#onChange(this.state);
  }

  // The image's pixel under a point of the canvas, and the layer that is seen there: {x, y, cell, index}.
  #under(point) {
    if (!point || !this.#size) return null;
    const cells = this.#cells();
    const at = Math.max(0, cells.findIndex((c) => point.x >= c.x && point.x < c.x + c.width && point.y >= c.y && point.y < c.y + c.height));
    const cell = cells[at];
    const place = this.#placement(cell);
    const x = Math.floor((point.x - cell.x - place.x) / place.scale);
    const y = Math.floor((point.y - cell.y - place.y) / place.scale);
    const wiped = this.#state.mode === 'wipe' && this.#shown.length === 2;
    const index = cells.length > 1 ? at : wiped && point.x > this.#state.share * cell.width ? 1 : 0;
    return {x, y, cell, index, inside: x >= 0 && y >= 0 && x < this.#size.width && y < this.#size.height};
  }

  // Drawing ------------------------------------------------------------------------------------------------------

  #draw() {
    if (!this.#size || this.#shown.length === 0) {
      this.#canvas.getContext('2d').clearRect(0, 0, this.#canvas.width, this.#canvas.height);
      return replace(this.#labels);
    }
    const {width, height} = this.#box();
    const density = window.devicePixelRatio || 1;
    const [w, t] = [Math.round(width * density), Math.round(height * density)];
    if (this.#canvas.width !== w || this.#canvas.height !== t) Object.assign(this.#canvas, {width: w, height: t});
    const context = this.#canvas.getContext('2d');
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    const cells = this.#cells();
    const wiped = this.#state.mode === 'wipe' && this.#shown.length === 2;
    const line = this.#state.share * width;
    if (wiped) {
      this.#drawPicture(context, this.#shown[0], cells[0], 0, line);
      this.#drawPicture(context, this.#shown[1], cells[0], line, width);
    } else {
      cells.forEach((cell, i) => this.#drawPicture(context, this.#shown[i], cell, 0, cell.width));
    }
    cells.forEach((cell) => this.#drawOver(context, cell));
    this.#handle.hidden = !wiped;
    this.#handle.style.left = `${line}px`;
    this.#wipe.disabled = !wiped;
    this.#wipe.value = Math.round(this.#state.share * 1000);
    this.#scaleText.textContent = `${significant(this.#placement(cells[0]).scale, 3)}×`;
    this.#drawLabels(cells, wiped, line, width);
    this.#drawMinimap(cells[0]);
    this.#drawMagnifier();
  }

  #drawPicture(context, picture, cell, from, to) {
    if (!picture || to <= from) return;
    const place = this.#placement(cell);
    context.save();
    context.beginPath();
    context.rect(cell.x + from, cell.y, to - from, cell.height);
    context.clip();
    // Enlarged pixels stay squares: what is compared are the pixels.
    context.imageSmoothingEnabled = place.scale * (window.devicePixelRatio || 1) < 1;
    context.imageSmoothingQuality = 'high';
    context.drawImage(picture.bitmap, cell.x + place.x, cell.y + place.y, picture.bitmap.width * place.scale, picture.bitmap.height * place.scale);
    context.restore();
  }

  // What lies over the pictures: borders of pixels, their values, the box.
  #drawOver(context, cell) {
    const place = this.#placement(cell);
    context.save();
    context.beginPath();
    context.rect(cell.x, cell.y, cell.width, cell.height);
    context.clip();
    context.translate(cell.x, cell.y);
    if (place.scale >= gridFrom) this.#drawGrid(context, place, cell);
    if (place.scale >= valuesFrom) this.#drawValues(context, place, cell);
    const {box} = this.#state;
    if (box) {
      for (const [colour, width] of [['#000', 4], ['#ffd23f', 2]]) {
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.strokeRect(place.x + box.x * place.scale, place.y + box.y * place.scale, box.width * place.scale, box.height * place.scale);
      }
    }
    context.restore();
    if (cell.x > 0 || cell.y > 0) {
      context.fillStyle = '#fff';
      if (cell.x > 0) context.fillRect(cell.x - 0.5, cell.y, 1, cell.height);
      if (cell.y > 0) context.fillRect(cell.x, cell.y - 0.5, cell.width, 1);
    }
  }

  #part(place, cell) {
    const x = clamp(Math.floor(-place.x / place.scale), 0, this.#size.width);
    const y = clamp(Math.floor(-place.y / place.scale), 0, this.#size.height);
    const right = clamp(Math.ceil((cell.width - place.x) / place.scale), 0, this.#size.width);
    const bottom = clamp(Math.ceil((cell.height - place.y) / place.scale), 0, this.#size.height);
    return {x, y, width: right - x, height: bottom - y};
  }

  #drawGrid(context, place, cell) {
    const part = this.#part(place, cell);
    context.strokeStyle = 'rgb(128 128 128 / 0.35)';
    context.lineWidth = 1;
    context.beginPath();
    for (let x = part.x; x <= part.x + part.width; ++x) {
      const at = Math.round(place.x + x * place.scale) + 0.5;
      context.moveTo(at, Math.max(0, place.y));
      context.lineTo(at, Math.min(cell.height, place.y + this.#size.height * place.scale));
    }
    for (let y = part.y; y <= part.y + part.height; ++y) {
      const at = Math.round(place.y + y * place.scale) + 0.5;
      context.moveTo(Math.max(0, place.x), at);
      context.lineTo(Math.min(cell.width, place.x + this.#size.width * place.scale), at);
    }
    context.stroke();
  }

  // The numbers of the layer that is seen, in its pixels.
  #drawValues(context, place, cell) {
    const index = this.#state.mode === 'side' ? this.#cells().findIndex((other) => other.x === cell.x && other.y === cell.y) : 0;
    const layer = this.#shown[index]?.layers[0];
    const part = this.#part(place, cell);
    if (!layer || part.width * part.height > 1200 || part.width * part.height === 0) return;
    const key = `${layer.url} ${Object.values(part)}`;
    if (this.#region?.key !== key) {
      if (this.#region?.asked !== key) {
        this.#region = {asked: key};
        ask('region', {layer: {url: layer.url, kind: layer.kind}, ...part}).then((rows) => {
          this.#region = {key, rows, ...part, type: layer.kind === 'display' ? 'byte' : layer.scale?.discrete ? 'uint' : 'half'};
          this.#draw();
        }, () => {});
      }
      return;
    }
    context.font = `${Math.min(13, place.scale / 5)}px monospace`;
    context.textAlign = 'center';
    context.textBaseline = 'middle';
    this.#region.rows.forEach((row, j) => row.forEach((values, i) => {
      const x = place.x + (part.x + i + 0.5) * place.scale;
      const y = place.y + (part.y + j + 0.5) * place.scale;
      values.forEach((value, c) => {
        const text = valueText(value, this.#region.type);
        const at = y + (c - (values.length - 1) / 2) * place.scale * 0.24;
        context.lineWidth = 3;
        context.strokeStyle = 'rgb(0 0 0 / 0.75)';
        context.strokeText(text, x, at);
        context.fillStyle = '#fff';
        context.fillText(text, x, at);
      });
    }));
  }

  #drawLabels(cells, wiped, line, width) {
    const label = (text, left, top, className = '') => {
      const element = h('span.view-label', {class: className}, text);
      element.style.left = `${left}px`;
      element.style.top = `${top}px`;
      return element;
    };
    const texts = this.#shown.map(({label: text}) => text);
    this.#canvas.setAttribute('aria-label', texts.join(wiped ? ' against ' : ', '));
    if (wiped) {
      replace(this.#labels, line >= 30 && h('span.view-label.left', {}, texts[0]), width - line >= 30 && h('span.view-label.right', {}, texts[1]));
    } else if (cells.length === 1) {
      const place = this.#state.mode === 'flip' ? `${this.#state.a + 1} of ${this.#layers.length}: ` : '';
      replace(this.#labels, h('span.view-label.left', {}, place, texts[0]));
    } else {
      replace(this.#labels, cells.map((cell, i) => label(texts[i], cell.x + 8, cell.y + 8)));
    }
  }

  #drawMinimap(cell) {
    const whole = this.#state.scale === 0 || this.#placement(cell).scale <= this.#fitScale(cell) * 1.01;
    this.#minimap.hidden = whole;
    if (whole) return;
    const {width, height} = this.#size;
    const scale = Math.min(160 / width, 110 / height);
    Object.assign(this.#minimap, {width: Math.round(width * scale), height: Math.round(height * scale)});
    const context = this.#minimap.getContext('2d');
    context.drawImage(this.#shown[0].bitmap, 0, 0, this.#minimap.width, this.#minimap.height);
    const place = this.#placement(cell);
    context.lineWidth = 2;
    context.strokeStyle = '#ffd23f';
    context.strokeRect((-place.x / place.scale) * scale, (-place.y / place.scale) * scale, (cell.width / place.scale) * scale, (cell.height / place.scale) * scale);
  }

  #drawMagnifier() {
    this.#magnifier.hidden = !this.#state.magnify || this.#shown.length === 0;
    const under = this.#under(this.#pointer ?? {x: this.#box().width / 2, y: this.#box().height / 2});
    if (this.#magnifier.hidden || !under) return;
    const context = this.#magnifier.getContext('2d');
    context.imageSmoothingEnabled = false;
    context.fillStyle = '#1a1d22';
    context.fillRect(0, 0, 187, 187);
    const picture = this.#shown[Math.min(under.index, this.#shown.length - 1)].bitmap;
    context.drawImage(picture, (8 - under.x) * 11, (8 - under.y) * 11, picture.width * 11, picture.height * 11);
    context.strokeStyle = '#ffd23f';
    context.lineWidth = 2;
    context.strokeRect(8 * 11, 8 * 11, 11, 11);
  }

  #toggleMagnifier() {
    this.#state.magnify = !this.#state.magnify;
    this.#draw();
    this.#onChange(this.state);
  }

  // Controls -----------------------------------------------------------------------------------------------------

  #drawControls() {
    const {share: _share, scale: _scale, cx: _cx, cy: _cy, box: _box, ...chosen} = this.#state;
    const key = JSON.stringify([chosen, this.#layers.map(({label, kind, scale}) => [label, kind, scale])]);
    if (key === this.#controlsFor) return;  // frames follow each other with the same ones
    this.#controlsFor = key;
    const {mode} = this.#state;
    const several = this.#layers.length > 1;
    const focus = document.activeElement?.dataset?.control;
    replace(this.#modeButtons, Object.entries(modes).map(([name, [title, key]]) => h('button.chip', {
      type: 'button', 'aria-pressed': String(mode === name), 'aria-keyshortcuts': key, 'data-control': name, disabled: !several,
      onclick: () => this.change({mode: name})}, title)));
    const select = (label, value, options, set, name) => field(label, h('select', {value, 'data-control': name, onchange: (event) => set(event.target.value)},
      options.map(([option, text]) => h('option', {value: option, selected: String(option) === String(value)}, text))));
    const layerOptions = this.#layers.map((layer, i) => [i, `${i + 1}: ${layer.label}`]);
    const {a, b, measure, signed, gain} = this.#state;
    replace(this.#sides, several && mode !== 'side' && [
      select(mode === 'flip' ? 'Shown' : mode === 'wipe' ? 'Left' : 'Of', a, layerOptions, (value) => this.change({a: Number(value)}), 'a'),
      mode !== 'flip' && select(mode === 'wipe' ? 'Right' : 'minus', b, layerOptions, (value) => this.change({b: Number(value)}), 'b'),
      mode === 'difference' && [
        select('Measure', measure, Object.entries(measures), (value) => this.change({measure: value}), 'measure'),
        select('Gain', gain, [1, 2, 4, 8, 16, 32, 64].map((v) => [v, `×${v}`]), (value) => this.change({gain: Number(value)}), 'gain'),
        h('label.check', {}, h('input', {type: 'checkbox', checked: signed, disabled: signless.includes(measure), 'data-control': 'signed', onchange: () => this.change({signed: !signed})}), 'signed'),
      ]]);
    this.#drawLook();
    this.#drawLegends();
    if (focus) this.element.querySelector(`[data-control="${focus}"]`)?.focus();
  }

  #drawLook() {
    const {exposure, tone, channel, falseColour, log, palette: named, low, high} = this.#state;
    const stops = `${exposure > 0 ? '+' : ''}${fixed(exposure, 2)} EV`;
    // A slider that is being drawn along stays the same one.
    const slider = this.#lookPanel.querySelector('[data-control="exposure"]');
    if (slider && slider === document.activeElement) {
      slider.value = exposure;
      this.#lookPanel.querySelector('output').textContent = stops;
      return;
    }
    const open = this.#lookPanel.querySelector('details')?.open ?? false;
    const number = (value, name) => h('input', {type: 'number', step: 'any', value: value ?? '', 'data-control': name, onchange: (event) =>
      this.change({[name]: event.target.value === '' ? null : event.target.valueAsNumber})});
    const choice = (value, options, name) => h('select', {'data-control': name, onchange: (event) => this.change({[name]: event.target.value})},
      options.map(([option, text]) => h('option', {value: option, selected: option === value}, text)));
    const check = (label, value, name) => h('label.check', {}, h('input', {type: 'checkbox', checked: value, 'data-control': name, onchange: (event) => this.change({[name]: event.target.checked})}), label);
    replace(this.#lookPanel, h('details', {open}, h('summary', {}, 'Exposure, tone and false colour'),
      h('div.look-fields', {},
        h('label.exposure', {}, h('span', {}, 'Exposure'), h('input', {type: 'range', min: -8, max: 8, step: 0.25, value: exposure, 'aria-label': 'Exposure in stops', 'data-control': 'exposure',
          oninput: (event) => this.change({exposure: event.target.valueAsNumber})}), h('output', {}, stops)),
        field('Tone', choice(tone, toneNames.map((name) => [name, {none: 'none (clamped)', reinhard: 'Reinhard', aces: 'ACES'}[name]]), 'tone')),
        field('Channel', choice(channel, Object.entries(channels), 'channel')),
        check('false colour', falseColour, 'falseColour'), check('logarithmic', log, 'log'),
        field('Colours', choice(named, [['', "each map's own"], ['viridis', 'viridis'], ['magma', 'magma'], ['grey', 'grey']], 'palette')),
        field('From', number(low, 'low')), field('To', number(high, 'high')),
        h('button', {type: 'button', onclick: () => this.resetLook()}, 'Reset'))));
  }

  resetLook() {
    this.change({exposure: 0, tone: 'none', channel: 'all', falseColour: false, log: false, palette: '', low: null, high: null});
  }

  #drawLegends() {
    const {mode, a, b, falseColour} = this.#state;
    const visible = mode === 'side' ? this.#layers : mode === 'wipe' ? [this.#layers[a], this.#layers[b]] : mode === 'flip' ? [this.#layers[a]] : [];
    const scales = visible.filter((layer) => layer && (isMap(layer) || falseColour)).map((layer) => this.#scaleOf(layer));
    const unique = [...new Map(scales.map((scale) => [JSON.stringify([scale.map, scale.low, scale.maximum, scale.log, scale.description]), scale])).values()];
    replace(this.#legends, unique.map(legend));
  }

  // Input --------------------------------------------------------------------------------------------------------

  #listen() {
    const canvas = this.#canvas;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return {x: event.clientX - box.left, y: event.clientY - box.top};
    };
    const nearLine = ({x}) => this.#state.mode === 'wipe' && this.#shown.length === 2 && Math.abs(x - this.#state.share * this.#box().width) < grab;
    let drag = null;
    canvas.addEventListener('pointerdown', (event) => {
      const point = at(event);
      canvas.setPointerCapture(event.pointerId);
      const what = event.shiftKey ? 'box' : nearLine(point) ? 'wipe' : 'pan';
      drag = {what, ...point, start: this.#under(point), from: point};
    });
    canvas.addEventListener('pointermove', (event) => {
      const point = at(event);
      this.#pointer = point;
      if (!drag) {
        canvas.classList.toggle('at-line', nearLine(point));
        this.#drawMagnifier();
        return this.#read();
      }
      if (drag.what === 'wipe') this.#setShare(point.x / this.#box().width);
      else if (drag.what === 'box') this.#dragBox(drag.start, this.#under(point));
      else if (this.#size && Math.hypot(point.x - drag.from.x, point.y - drag.from.y) > 3) {
        drag.moved = true;
        this.#pan(point.x - drag.x, point.y - drag.y);
        Object.assign(drag, point);
      }
    });
    canvas.addEventListener('pointerup', () => {
      if (drag?.what === 'box') this.#boxChanged();
      else if (drag?.what === 'pan' && !drag.moved && drag.start?.inside) {
        // Whoever explains a pixel listens for this.
        const {x, y, index} = drag.start;
        this.element.dispatchEvent(new CustomEvent('pixelchosen', {bubbles: true, detail: {x, y, layer: this.#shown[index]?.layers[0]}}));
      }
      drag = null;
    });
    canvas.addEventListener('pointercancel', () => (drag = null));
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      const under = this.#under(at(event));
      if (!under) return;
      const {cell} = under;
      const point = at(event);
      this.#zoomTo(this.#placement(cell).scale * 1.25 ** -Math.sign(event.deltaY), cell, point.x - cell.x, point.y - cell.y);
    }, {passive: false});
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.#size) return;
      const step = 40;
      const [dx, dy] = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[event.key] ?? [0, 0];
      if (dx === 0 && dy === 0) return;
      event.preventDefault();
      if (event.shiftKey && this.#state.box) this.#moveBox(-dx, -dy);
      else this.#pan(dx * step, dy * step);
    });
    let onMap = false;
    const jump = (event) => {
      const box = this.#minimap.getBoundingClientRect();
      this.goTo(((event.clientX - box.left) / box.width) * this.#size.width, ((event.clientY - box.top) / box.height) * this.#size.height, this.#placement().scale);
    };
    this.#minimap.addEventListener('pointerdown', (event) => {
      onMap = true;
      this.#minimap.setPointerCapture(event.pointerId);
      jump(event);
    });
    this.#minimap.addEventListener('pointermove', (event) => onMap && jump(event));
    this.#minimap.addEventListener('pointerup', () => (onMap = false));
  }

  /** The view's keys, for keys.js. */
  keys() {
    const change = (entries) => () => this.change(entries());
    const next = (list, value) => list[(list.indexOf(value) + 1) % list.length];
    const s = () => this.#state;
    return [
      ...Object.entries(modes).map(([mode, [title, key]]) => ({keys: [key], text: title, act: change(() => ({mode}))})),
      {keys: ['1', '2', '3', '4', '5', '6'], text: 'flip to that layer', act: (key) => Number(key) <= this.#layers.length && this.change({mode: 'flip', a: Number(key) - 1})},
      {keys: ['b'], text: 'swap the two layers', act: change(() => ({a: s().b, b: s().a}))},
      {keys: [','], text: 'line to the left', act: () => this.#setShare(s().share - 0.02)},
      {keys: ['.'], text: 'line to the right', act: () => this.#setShare(s().share + 0.02)},
      {keys: ['0'], text: 'whole image', act: () => this.#zoomTo(0)},
      {keys: ['+', '='], text: 'zoom in', act: () => this.#zoomBy(1.5)},
      {keys: ['-'], text: 'zoom out', act: () => this.#zoomBy(1 / 1.5)},
      {keys: ['z'], text: 'next zoom of 1, 2, 4, … 64', act: () => this.#size && this.#zoomTo(zoomSteps.find((step) => step > this.#placement().scale * 1.01) ?? 1)},
      {keys: ['e'], text: 'brighter by half a stop', act: change(() => ({exposure: Math.min(8, s().exposure + 0.5)}))},
      {keys: ['E'], text: 'darker by half a stop', act: change(() => ({exposure: Math.max(-8, s().exposure - 0.5)}))},
      {keys: ['t'], text: 'next tone curve', act: change(() => ({tone: next(toneNames, s().tone)}))},
      {keys: ['c'], text: 'next channel', act: change(() => ({channel: next(Object.keys(channels), s().channel)}))},
      {keys: ['o'], text: 'false colour', act: change(() => ({falseColour: !s().falseColour}))},
      {keys: ['l'], text: 'logarithmic colours', act: change(() => ({log: !s().log}))},
      {keys: ['g'], text: 'difference: twice the gain', act: change(() => ({gain: Math.min(64, s().gain * 2)}))},
      {keys: ['G'], text: 'difference: half the gain', act: change(() => ({gain: Math.max(1, s().gain / 2)}))},
      {keys: ['n'], text: 'difference: with its sign', act: change(() => ({signed: !s().signed}))},
      {keys: ['q'], text: 'difference: next measure', act: change(() => ({measure: next(Object.keys(measures), s().measure)}))},
      {keys: ['m'], text: 'magnifier', act: () => this.#toggleMagnifier()},
      {keys: ['x'], text: 'a box in the middle of what is seen, or none', act: () => this.#boxHere()},
      {keys: ['v'], text: 'list of the worst places', act: () => this.showWorst()},
    ];
  }

  /** What else there is to know of the view's keys and pointer. */
  static hints = [
    {keys: ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], text: 'on the picture: move it; with Shift: move the box', act: () => {}},
    {keys: ['drag'], text: 'move the picture or the line; with Shift: draw a box', act: () => {}},
    {keys: ['wheel'], text: 'zoom', act: () => {}},
  ];

  // Reading ------------------------------------------------------------------------------------------------------

  // The true values of every layer under the pointer.
  async #read() {
    const under = this.#under(this.#pointer);
    if (!under?.inside) {
      this.#readout.textContent = 'Point at a pixel for its values.';
      return;
    }
    if (this.#reading) return;  // the next move asks again
    this.#reading = true;
    const layers = this.#layers;
    const {x, y} = under;
    try {
      const values = await ask('values', {layers: layers.map(({url, kind}) => ({url, kind})), x, y});
      const {mode, a, b, measure} = this.#state;
      const apart = mode === 'difference' && layers[a] && layers[b] ? await ask('differenceAt', {a: layers[a], b: layers[b], measure, x, y}) : null;
      this.element.dataset.values = JSON.stringify({x, y, values: values.map((entry) => entry?.values)});  // for tests
      replace(this.#readout, h('span.sample', {}, `x ${x}, y ${y}`), values.map((entry, i) => entry && h('span.sample', {}, h('b', {}, `${i + 1} ${layers[i].label}`), ' ',
        entry.values.map((value) => valueText(value, entry.type)).join(' '), (layers[i].scale?.unit || entry.unit) && ` ${layers[i].scale?.unit || entry.unit}`)),
      apart !== null && h('span.sample', {}, h('b', {}, 'difference'), ` ${valueText(apart, 'half')}`));
    } catch {
      // The layers' own failure is told by #load().
    }
    this.#reading = false;
    const now = this.#under(this.#pointer);
    if (now && (now.x !== x || now.y !== y)) this.#read();
  }

  // The box ------------------------------------------------------------------------------------------------------

  #dragBox(from, to) {
    if (!from || !to) return;
    const side = (a, b, size) => [clamp(Math.min(a, b), 0, size - 1), clamp(Math.max(a, b), 0, size - 1)];
    const [left, right] = side(from.x, to.x, this.#size.width);
    const [top, bottom] = side(from.y, to.y, this.#size.height);
    this.#state.box = {x: left, y: top, width: right - left + 1, height: bottom - top + 1};
    this.#draw();
  }

  #boxHere() {
    if (!this.#size) return;
    if (this.#state.box) {
      this.#state.box = null;
    } else {
      const cell = this.#cells()[0];
      const part = this.#part(this.#placement(cell), cell);
      const [width, height] = [Math.max(1, Math.round(part.width / 3)), Math.max(1, Math.round(part.height / 3))];
      this.#state.box = {x: part.x + Math.floor((part.width - width) / 2), y: part.y + Math.floor((part.height - height) / 2), width, height};
    }
    this.#boxChanged();
  }

  #moveBox(dx, dy) {
    const {box} = this.#state;
    box.x = clamp(box.x + dx, 0, this.#size.width - box.width);
    box.y = clamp(box.y + dy, 0, this.#size.height - box.height);
    this.#boxChanged();
  }

  #boxChanged() {
    this.#draw();
    this.#onChange(this.state);
    this.#measureBox();
  }

  async #measureBox() {
    const {box} = this.#state;
    if (!box || !this.#size) return replace(this.#boxPanel);
    const inside = {x: clamp(box.x, 0, this.#size.width - 1), y: clamp(box.y, 0, this.#size.height - 1)};
    Object.assign(inside, {width: clamp(box.width, 1, this.#size.width - inside.x), height: clamp(box.height, 1, this.#size.height - inside.y)});
    const layers = this.#layers;
    let figures;
    try {
      figures = await ask('box', {box: inside, layers: layers.map(({url, kind, reference, scale}) =>
        ({url, kind, reference: reference && {url: reference.url, kind: reference.kind}, high: scale?.maximum ?? 1}))});
    } catch (error) {
      return replace(this.#boxPanel, h('p.problem', {}, error.message));
    }
    if (this.#state.box !== box) return;
    const percent = (share) => `${fixed(100 * share, 2)} %`;
    const rows = layers.map((layer, i) => ({layer, figures: figures[i]})).filter((row) => row.figures);
    replace(this.#boxPanel, h('div.section-head', {}, h('h3', {}, `Box at ${inside.x}, ${inside.y} of ${inside.width}×${inside.height} pixels`),
      h('button.plain', {type: 'button', onclick: () => this.#boxHere()}, 'Close the box')),
    h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'Figures of the box'}, h('table.box-figures', {}, h('thead', {}, h('tr', {},
      ['Layer', 'Of', 'Mean', 'Largest', 'Sum', 'Share of the whole', 'Histogram'].map((title) => h('th', {scope: 'col'}, title)))),
    h('tbody', {}, rows.map(({layer, figures: f}) => h('tr', {}, h('th', {scope: 'row'}, layer.label),
      h('td', {}, isMap(layer) ? layer.scale?.unit || 'value' : 'error'),
      h('td.number', {}, valueText(f.mean, 'half')), h('td.number', {}, valueText(f.largest, 'half')), h('td.number', {}, shortCount(f.sum) === missing ? missing : isMap(layer) && layer.scale?.discrete ? count(f.sum) : significant(f.sum, 4)),
      h('td.number', {}, percent(f.share)), h('td', {}, histogram(f))))))));
  }

  // The worst places ----------------------------------------------------------------------------------------------

  /** Lists the 50 places where a layer has most: of an error map its own, of an image its error. */
  async showWorst() {
    if (this.#worstPanel.hasChildNodes()) return replace(this.#worstPanel);
    const shown = [this.#layers[this.#state.a], ...this.#layers];
    const layer = shown.find((candidate) => candidate && (candidate.reference || isMap(candidate)));
    if (!layer) return replace(this.#worstPanel, h('p.quiet', {}, 'None of these layers has an error: there is no reference.'));
    let places;
    let picture;
    try {
      const reference = layer.reference && {url: layer.reference.url, kind: layer.reference.kind};
      places = await ask('worst', {layer: {url: layer.url, kind: layer.kind, reference}});
      picture = await bitmap('colour', {layer: {url: layer.url, kind: layer.kind}, look: this.#lookOf(layer)});
    } catch (error) {
      return replace(this.#worstPanel, h('p.problem', {}, error.message));
    }
    replace(this.#worstPanel, h('div.section-head', {}, h('h3', {}, `Worst places of ${layer.label}`),
      h('button.plain', {type: 'button', onclick: () => replace(this.#worstPanel)}, 'Close the list')),
    places.length === 0 ? h('p.quiet', {}, 'There are none: it is 0 everywhere.') : h('ol.worst', {}, places.map((place, i) => {
      const canvas = h('canvas', {width: 72, height: 72, 'aria-hidden': true});
      const context = canvas.getContext('2d');
      context.imageSmoothingEnabled = false;
      context.drawImage(picture.bitmap, place.x - 12, place.y - 12, 24, 24, 0, 0, 72, 72);
      return h('li', {}, h('button.place', {type: 'button', 'aria-label': `Place ${i + 1}: x ${place.x}, y ${place.y}, ${valueText(place.value, 'half')}`, onclick: () => {
        this.goTo(place.x + 0.5, place.y + 0.5, 16);
        announce(`x ${place.x}, y ${place.y}`);
        this.#canvas.scrollIntoView({block: 'nearest'});
      }}, canvas, h('span', {}, valueText(place.value, 'half'))));
    })));
  }

  /** What is on the screen as a picture of its own, for reports. */
  pictureUrl() {
    return this.#shown.length > 0 ? this.#canvas.toDataURL('image/png') : null;
  }
}

function histogram({histogram: steps, high}) {
  const most = Math.max(...steps, 1);
  const bars = h('span.steps', {role: 'img', 'aria-label': `Pixels from 0 to ${valueText(high, 'half')}: ${steps.join(', ')}`}, steps.map((value) => {
    const bar = h('i', {});
    bar.style.height = `${value > 0 ? Math.max(6, (100 * value) / most) : 0}%`;
    return bar;
  }));
  return bars;
}
