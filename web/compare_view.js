// Two to six layers of one frame in one place: wiped, flipped, side by side in step, or subtracted. The layers are numbers;
// what they look like is chosen here. Place and zoom stay when the layers change, so that techniques, frames and runs can be
// compared at one spot.
import {h, setText} from './dom.js';
import {significant} from './format.js';
import {bitmap} from './pixels.js';
import {BoxPanel, boxBetween, boxInMiddle} from './view_box.js';
import {ViewControls} from './view_controls.js';
import {clamp, ViewGeometry} from './view_geometry.js';
import {listenToView} from './view_input.js';
import {ViewPainter} from './view_painter.js';
import {ViewReadout} from './view_readout.js';
import {coloured, firstState, maxLayers, picturesOf} from './view_state.js';
import {WorstPlaces} from './view_worst.js';

export class CompareView {
  #state = {...firstState};
  geometry = new ViewGeometry(this.#state);
  #painter = new ViewPainter(this.geometry, this.#state, () => this.#draw());
  #controls = new ViewControls((state) => this.change(state));
  #readout = new ViewReadout(() => this.geometry.under(this.#pointer));
  #boxPanel = new BoxPanel(() => this.boxHere());
  #worst = new WorstPlaces((x, y) => {
    this.goTo(x + 0.5, y + 0.5, 16);
    this.#painter.canvas.scrollIntoView({block: 'nearest'});
  }, () => this.toggleWorst());
  #message = h('p.view-message', {role: 'status', hidden: true});
  #wipe = h('input', {type: 'range', min: 0, max: 1000, value: 500, 'aria-label': 'Position of the dividing line', oninput: () => this.setShare(this.#wipe.value / 1000)});
  #scaleText = h('span.quiet.scale', {});
  #onChange;
  #layers = [];
  #shown = [];          // what is on the canvas: [{layers, bitmap, label}]
  #pointer = null;      // {x, y} where it was last over the canvas
  #measuredCanvas = false;
  #busy = false;
  #again = false;
  #settled = Promise.resolve();
  #closed = false;
  // The canvas's size is told and not asked for: asking makes the browser lay the page out at once.
  #resize = new ResizeObserver((entries) => {
    const {width, height} = entries.at(-1).contentRect;
    this.#measuredCanvas = width > 0;
    this.geometry.canvas = {width: Math.max(1, width), height: Math.max(1, height)};
    this.#draw();
  });

  /** `onChange(state)` is told whatever the user changes, for the address. */
  constructor(onChange = () => {}) {
    this.#onChange = onChange;
    const zoomButton = (label, act, title) => h('button.plain', {type: 'button', title, 'aria-label': `${label} ${title}`, onclick: act}, label);
    this.#painter.element.append(this.#message);
    this.element = h('div.view', {'aria-busy': 'true'},
      this.#controls.modes, this.#controls.sides, this.#painter.element,
      h('div.view-controls', {},
        h('label.wipe', {}, h('span', {}, 'Wipe'), this.#wipe),
        h('span.zoom', {}, zoomButton('Fit', () => this.zoomTo(0), 'Whole image'), zoomButton('−', () => this.zoomBy(1 / 1.5), 'Zoom out'),
          zoomButton('+', () => this.zoomBy(1.5), 'Zoom in'), zoomButton('1×', () => this.zoomTo(1), 'One pixel each'),
          zoomButton('8×', () => this.zoomTo(8), 'Eight times'), zoomButton('64×', () => this.zoomTo(64), 'Values in the pixels')),
        this.#scaleText,
        h('button', {type: 'button', onclick: () => this.boxHere()}, 'Box'),
        h('button', {type: 'button', onclick: () => this.toggleMagnifier()}, 'Magnifier'),
        h('button', {type: 'button', onclick: () => this.toggleWorst()}, 'Worst places')),
      this.#readout.element, this.#controls.legends, this.#controls.look, this.#boxPanel.element, this.#worst.element);
    listenToView(this, this.#painter.canvas, this.#painter.minimap);
    this.#resize.observe(this.#painter.canvas);
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

  /** Shows these layers, 1 to 6 (view_state.js says what one is). `state` changes what it names. */
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

  /** Marks a pixel of the pictures, null none. */
  mark(pixel) {
    this.#painter.marked = pixel;
    this.#draw();
  }

  /** Changes the state, draws it and tells. */
  change(state) {
    Object.assign(this.#state, state);
    this.#onChange(this.state);
    this.#refresh();
  }

  /** Legends, the box's figures and the worst places, which have children while they are shown. */
  get panels() {
    return [this.#controls.legends, this.#boxPanel.element, this.#worst.element];
  }

  /** What is on the screen as a picture of its own, for reports. */
  pictureUrl() {
    return this.#painter.pictureUrl();
  }

  // What is shown ------------------------------------------------------------------------------------------------

  // One at a time: while one is on its way, only the last of what is asked for meanwhile follows.
  #refresh() {
    this.#controls.draw(this.#state, this.#layers);
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
      const wanted = picturesOf(this.#state, this.#layers);
      try {
        const pictures = await Promise.all(wanted.map(({operation, request}) => bitmap(operation, request)));
        this.#shown = wanted.map((entry, i) => ({...entry, bitmap: pictures[i].bitmap}));
        this.geometry.size = pictures[0] && {width: pictures[0].width, height: pictures[0].height};
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
    this.#worst.follow(this.#state, this.#layers);
    this.#readAhead();
  }

  /** Fetches what these layers, as many as are shown, will look like: the next frame's. */
  readAhead(layers) {
    if (layers.length !== this.#layers.length) return;
    for (const {operation, request} of picturesOf(this.#state, layers)) bitmap(operation, request).catch(() => {});
  }

  // The other layers, so that flipping to them is at once.
  #readAhead() {
    if (this.#state.mode !== 'flip') return;
    for (const layer of this.#layers) {
      const {operation, request} = coloured(this.#state, layer);
      bitmap(operation, request).catch(() => {});
    }
  }

  #say(text) {
    setText(this.#message, text);
    this.#message.hidden = text === '';
  }

  #draw() {
    this.geometry.number = this.#shown.length;
    if (!this.#measuredCanvas) {  // before the observer's first word
      const {width, height} = this.#painter.canvas.getBoundingClientRect();
      this.geometry.canvas = {width: Math.max(1, width), height: Math.max(1, height)};
    }
    this.#painter.draw(this.#shown, this.#layers.length, this.#pointer);
    if (this.#shown.length === 0) return;
    this.#wipe.disabled = !this.geometry.wiped;
    this.#wipe.value = Math.round(this.#state.share * 1000);
    setText(this.#scaleText, `${significant(this.geometry.placement().scale, 3)}×`);
  }

  // Place and zoom -----------------------------------------------------------------------------------------------

  /** Brings an image point into the middle. */
  goTo(x, y, scale) {
    this.#move(() => this.geometry.goTo(x, y, scale));
  }

  /** Zooms so that what is under `point` of the cell stays where it is. 0: the whole image. */
  zoomTo(scale, cell, point) {
    this.#move(() => this.geometry.zoomTo(scale, cell, point));
  }

  zoomBy(factor) {
    this.#move(() => this.geometry.zoomTo(this.geometry.placement().scale * factor));
  }

  pan(dx, dy) {
    this.#move(() => this.geometry.pan(dx, dy));
  }

  #move(change) {
    if (!this.geometry.size) return;
    change();
    this.#draw();
    this.#read();
    this.#onChange(this.state);
  }

  setShare(share) {
    this.#state.share = clamp(share, 0, 1);
    this.#draw();
    this.#onChange(this.state);
  }

  toggleMagnifier() {
    this.#state.magnify = !this.#state.magnify;
    this.#draw();
    this.#onChange(this.state);
  }

  // The pointer, the box and the worst places --------------------------------------------------------------------

  /** The pointer is here. */
  point(point) {
    this.#pointer = point;
    this.#painter.drawMagnifier(point);
    this.#read();
  }

  #read() {
    this.#readout.read(this.#state, this.#layers, (told) => (this.element.dataset.values = JSON.stringify(told)));  // for tests
  }

  /** Whoever explains a pixel listens for "pixelchosen". */
  choosePixel({x, y, index}) {
    this.element.dispatchEvent(new CustomEvent('pixelchosen', {bubbles: true, detail: {x, y, layer: this.#shown[index]?.layers[0]}}));
  }

  /** The pixel under the pointer; without one, in the middle of what is seen. */
  chooseHere() {
    const {width, height} = this.geometry.canvas;
    const under = this.geometry.under(this.#pointer ?? {x: width / 2, y: height / 2});
    if (under?.inside) this.choosePixel(under);
  }

  dragBox(from, to) {
    if (!from || !to) return;
    this.#state.box = boxBetween(from, to, this.geometry.size);
    this.#draw();
  }

  boxHere() {
    if (!this.geometry.size) return;
    this.#state.box = this.#state.box ? null : boxInMiddle(this.geometry.part());
    this.boxChanged();
  }

  moveBox(dx, dy) {
    const {box} = this.#state;
    const {width, height} = this.geometry.size;
    this.#state.box = {...box, x: clamp(box.x + dx, 0, width - box.width), y: clamp(box.y + dy, 0, height - box.height)};
    this.boxChanged();
  }

  boxChanged() {
    this.#draw();
    this.#onChange(this.state);
    this.#measureBox();
  }

  #measureBox() {
    this.#boxPanel.measure(this.#state.box, this.geometry.size, this.#layers);
  }

  toggleWorst() {
    this.#state.worst = !this.#state.worst;
    this.#onChange(this.state);
    this.#worst.follow(this.#state, this.#layers);
  }
}
