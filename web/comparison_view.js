// Two images of the same frame in one place, divided by a line that can be dragged, with nearest-neighbour zoom. The place
// and zoom stay when the images change, so that techniques and frames can be compared at one spot.
import {valueOf} from './colour_scales.js';
import {h, replace} from './dom.js';
import {fixed, significant} from './format.js';

const maxScale = 64;
const gridFrom = 12;    // CSS pixels per image pixel from which pixel borders are drawn
const grab = 14;        // how near to the line a pointer takes hold of it
const cacheSize = 48;

const images = new Map();  // url -> promise of an image, least recently used first

function load(url) {
  const cached = images.get(url);
  images.delete(url);
  const promise = cached ?? new Promise((resolve, reject) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => {
      images.delete(url);
      reject(new Error('the image could not be loaded'));
    };
    image.src = url;
  });
  images.set(url, promise);
  if (images.size > cacheSize) images.delete(images.keys().next().value);
  return promise;
}

// The pixels of an image, read once.
const pixelsOf = (() => {
  const known = new WeakMap();
  return (image) => {
    let data = known.get(image);
    if (!data) {
      const canvas = new OffscreenCanvas(image.naturalWidth, image.naturalHeight);
      const context = canvas.getContext('2d', {willReadFrequently: true});
      context.drawImage(image, 0, 0);
      data = context.getImageData(0, 0, canvas.width, canvas.height);
      known.set(image, data);
    }
    return data;
  };
})();

export class ComparisonView {
  #canvas = h('canvas.view-canvas', {tabindex: 0, role: 'img', 'aria-label': 'Rendered frame'});
  #leftLabel = h('span.view-label.left', {});
  #rightLabel = h('span.view-label.right', {});
  #handle = h('div.wipe-handle', {'aria-hidden': true}, h('span', {}, '⇔'));
  #wipe = h('input', {type: 'range', min: 0, max: 1000, value: 500, 'aria-label': 'Position of the dividing line', oninput: () => this.#setWipe(this.#wipe.value / 1000)});
  #readout = h('output.readout', {}, 'Point at a pixel for its values.');
  #scaleText = h('span.quiet.scale', {});
  #left = null;   // {image, label, scale}
  #right = null;
  #share = 0.5;   // where the line is
  #scale = 1;     // CSS pixels per image pixel
  #centre = null; // image coordinates in the middle of the canvas; null: fit
  #turn = 0;
  #pointer = {x: -1, y: -1};  // where it was last over the canvas
  onpick = null;  // called with the pixel {x, y} that was clicked, or chosen by Enter under the pointer
  #resize = new ResizeObserver(() => this.#draw());

  constructor() {
    const zoomButton = (label, scale, title) => h('button.plain', {type: 'button', title, onclick: () => this.#zoomTo(scale)}, label);
    this.element = h('div.view', {},
      h('div.view-stage', {}, this.#canvas, this.#handle, this.#leftLabel, this.#rightLabel),
      h('div.view-controls', {},
        h('label.wipe', {}, h('span', {}, 'Wipe'), this.#wipe),
        h('span.zoom', {}, zoomButton('Fit', 0, 'Whole image (key 0)'), zoomButton('1×', 1, 'One pixel each (key 1)'),
          zoomButton('4×', 4, 'Key 4'), zoomButton('8×', 8, 'Key 8'), zoomButton('16×', 16, 'Key 6')), this.#scaleText),
      this.#readout,
      h('p.quiet.help', {}, 'Drag to move, wheel or + and − to zoom, arrow keys to move, comma and full stop to wipe, B to blink between the two. A click tells the pixel\'s story, Enter that of the pixel under the pointer.'));
    this.#listen();
    this.#resize.observe(this.#canvas);
  }

  close() {
    this.#resize.disconnect();
  }

  /**
   * Shows `left` and, right of the line, `right` (null: none). Each {url, label, scale}; `scale` for maps, whose pixels
   * are then read as values. `share` moves the line.
   */
  async show(left, right, share = null) {
    const mine = ++this.#turn;
    const wanted = [left, right].map(async (side) => side && {...side, image: await load(side.url)});
    let loaded;
    try {
      loaded = await Promise.all(wanted);
    } catch (error) {
      if (mine === this.#turn) this.#readout.textContent = `This can't be shown: ${error.message}`;
      return;
    }
    if (mine !== this.#turn) return;  // something else was asked for meanwhile
    [this.#left, this.#right] = loaded;
    if (share !== null) this.#share = share;
    replace(this.#leftLabel, left?.label ?? '');
    replace(this.#rightLabel, right?.label ?? '');
    this.#canvas.setAttribute('aria-label', right ? `${left.label} against ${right.label}` : left.label);
    this.element.dataset.shown = left.url;  // tells tests that the images are on the screen
    this.#setWipe(this.#share);
    this.#read(this.#pointer);
  }

  #size() {
    const box = this.#canvas.getBoundingClientRect();
    return {width: Math.max(1, box.width), height: Math.max(1, box.height)};
  }

  #fitScale() {
    const {width, height} = this.#size();
    return Math.min(width / this.#left.image.naturalWidth, height / this.#left.image.naturalHeight);
  }

  // Scale and the image's top left corner in CSS pixels.
  #placement() {
    const {width, height} = this.#size();
    const {naturalWidth, naturalHeight} = this.#left.image;
    const scale = this.#centre ? this.#scale : this.#fitScale();
    const centre = this.#centre ?? {x: naturalWidth / 2, y: naturalHeight / 2};
    return {scale, x: width / 2 - centre.x * scale, y: height / 2 - centre.y * scale};
  }

  #setWipe(share) {
    this.#share = Math.min(Math.max(share, 0), 1);
    this.#wipe.value = Math.round(this.#share * 1000);
    this.#draw();
  }

  // Zooms so that the image point under (x, y), by default the middle, stays where it is.
  #zoomTo(scale, x, y) {
    if (!this.#left) return;
    if (scale === 0) {
      this.#centre = null;
    } else {
      const {width, height} = this.#size();
      const place = this.#placement();
      const [px, py] = [x ?? width / 2, y ?? height / 2];
      const point = {x: (px - place.x) / place.scale, y: (py - place.y) / place.scale};
      this.#scale = Math.min(Math.max(scale, Math.min(this.#fitScale(), 1) / 2), maxScale);
      this.#moveCentre(point.x + (width / 2 - px) / this.#scale, point.y + (height / 2 - py) / this.#scale);
    }
    this.#draw();
  }

  #moveCentre(x, y) {
    const {naturalWidth, naturalHeight} = this.#left.image;
    this.#centre = {x: Math.min(Math.max(x, 0), naturalWidth), y: Math.min(Math.max(y, 0), naturalHeight)};
  }

  #pan(dx, dy) {
    if (!this.#left) return;
    const {width, height} = this.#size();
    const {scale, x, y} = this.#placement();
    this.#scale = scale;
    this.#moveCentre((width / 2 - x - dx) / scale, (height / 2 - y - dy) / scale);
    this.#draw();
  }

  #draw() {
    if (!this.#left) return;
    const {width, height} = this.#size();
    const density = window.devicePixelRatio || 1;
    this.#canvas.width = Math.round(width * density);
    this.#canvas.height = Math.round(height * density);
    const context = this.#canvas.getContext('2d');
    context.scale(density, density);
    const place = this.#placement();
    const line = this.#right ? this.#share * width : width;
    const part = (side, from, to) => {
      if (!side || to <= from) return;
      context.save();
      context.beginPath();
      context.rect(from, 0, to - from, height);
      context.clip();
      // Enlarged pixels stay squares: what is compared are the pixels.
      context.imageSmoothingEnabled = place.scale * density < 1;
      context.imageSmoothingQuality = 'high';
      const {naturalWidth, naturalHeight} = this.#left.image;
      context.drawImage(side.image, place.x, place.y, naturalWidth * place.scale, naturalHeight * place.scale);
      context.restore();
    };
    part(this.#left, 0, line);
    part(this.#right, line, width);
    if (place.scale >= gridFrom) this.#drawGrid(context, place, width, height);
    this.#handle.hidden = !this.#right;
    this.#handle.style.left = `${line}px`;
    this.#wipe.disabled = !this.#right;
    this.#leftLabel.hidden = line < 30;
    this.#rightLabel.hidden = !this.#right || width - line < 30;
    this.#scaleText.textContent = `${significant(place.scale, 3)}×`;
  }

  #drawGrid(context, place, width, height) {
    const {naturalWidth, naturalHeight} = this.#left.image;
    context.strokeStyle = 'rgb(128 128 128 / 0.35)';
    context.lineWidth = 1;
    context.beginPath();
    const firstX = Math.max(0, Math.floor(-place.x / place.scale));
    for (let x = firstX; x <= naturalWidth && place.x + x * place.scale <= width; ++x) {
      const at = Math.round(place.x + x * place.scale) + 0.5;
      context.moveTo(at, Math.max(0, place.y));
      context.lineTo(at, Math.min(height, place.y + naturalHeight * place.scale));
    }
    const firstY = Math.max(0, Math.floor(-place.y / place.scale));
    for (let y = firstY; y <= naturalHeight && place.y + y * place.scale <= height; ++y) {
      const at = Math.round(place.y + y * place.scale) + 0.5;
      context.moveTo(Math.max(0, place.x), at);
      context.lineTo(Math.min(width, place.x + naturalWidth * place.scale), at);
    }
    context.stroke();
  }

  #listen() {
    const canvas = this.#canvas;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      return {x: event.clientX - box.left, y: event.clientY - box.top};
    };
    const nearLine = ({x}) => this.#right && Math.abs(x - this.#share * this.#size().width) < grab;
    let drag = null;
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      drag = {wipe: nearLine(at(event)), ...at(event), from: at(event)};
    });
    canvas.addEventListener('pointermove', (event) => {
      const point = at(event);
      if (!drag) {
        canvas.classList.toggle('at-line', Boolean(nearLine(point)));
        this.#read(point);
      } else if (drag.wipe) {
        this.#setWipe(point.x / this.#size().width);
      } else {
        this.#pan(point.x - drag.x, point.y - drag.y);
        Object.assign(drag, point);
      }
    });
    canvas.addEventListener('pointerup', (event) => {
      const point = at(event);
      if (drag && !drag.wipe && Math.hypot(point.x - drag.from.x, point.y - drag.from.y) < 3) this.#pick(point);
      drag = null;
    });
    canvas.addEventListener('pointercancel', () => (drag = null));
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      if (!this.#left) return;
      const point = at(event);
      this.#zoomTo(this.#placement().scale * 1.25 ** -Math.sign(event.deltaY), point.x, point.y);
      this.#read(point);
    }, {passive: false});
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.#left) return;
      const zoom = (factor) => this.#zoomTo(this.#placement().scale * factor);
      const actions = {
        ArrowLeft: () => this.#pan(40, 0), ArrowRight: () => this.#pan(-40, 0),
        ArrowUp: () => this.#pan(0, 40), ArrowDown: () => this.#pan(0, -40),
        '+': () => zoom(1.5), '=': () => zoom(1.5), '-': () => zoom(1 / 1.5),
        0: () => this.#zoomTo(0), 1: () => this.#zoomTo(1), 4: () => this.#zoomTo(4), 8: () => this.#zoomTo(8), 6: () => this.#zoomTo(16),
        ',': () => this.#setWipe(this.#share - 0.02), '.': () => this.#setWipe(this.#share + 0.02),
        b: () => this.#setWipe(this.#share > 0.5 ? 0 : 1),
        Enter: () => this.#pick(this.#pointer),
      };
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    });
  }

  #pick({x, y}) {
    if (!this.#left || !this.onpick) return;
    const place = this.#placement();
    const pixel = {x: Math.floor((x - place.x) / place.scale), y: Math.floor((y - place.y) / place.scale)};
    const {naturalWidth, naturalHeight} = this.#left.image;
    if (pixel.x >= 0 && pixel.y >= 0 && pixel.x < naturalWidth && pixel.y < naturalHeight) this.onpick(pixel);
  }

  // Says what the images hold at a place of the canvas.
  #read({x, y}) {
    if (!this.#left) return;
    this.#pointer = {x, y};
    const place = this.#placement();
    const px = Math.floor((x - place.x) / place.scale);
    const py = Math.floor((y - place.y) / place.scale);
    const values = [this.#left, this.#right].filter(Boolean).map((side) => {
      const data = pixelsOf(side.image);
      if (px < 0 || py < 0 || px >= data.width || py >= data.height) return null;
      const offset = 4 * (py * data.width + px);
      return {side, pixel: [...data.data.slice(offset, offset + 3)]};
    });
    if (values.length === 0 || values.includes(null)) {
      this.#readout.textContent = 'Point at a pixel for its values.';
      return;
    }
    const parts = values.map(({side, pixel}) => {
      const swatch = h('span.swatch', {});
      swatch.style.background = `rgb(${pixel.join(' ')})`;
      const value = side.scale ? valueOf(side.scale, pixel) : null;
      const text = side.scale
        ? (Number.isFinite(value) ? `${value >= side.scale.maximum ? '≥ ' : side.scale.discrete ? '' : '≈ '}${side.scale.discrete ? Math.round(value) : significant(value, 3)} ${side.scale.unit}` : 'no value')
        : pixel.map((v) => fixed(v / 255, 3)).join(' ');
      return h('span.sample', {}, swatch, h('b', {}, side.label), ' ', text);
    });
    const comparable = values.length === 2 && values.every(({side}) => !side.scale);
    const difference = comparable && Math.max(...values[0].pixel.map((v, c) => Math.abs(v - values[1].pixel[c]))) / 255;
    replace(this.#readout, h('span.sample', {}, `x ${px}, y ${py}`), parts,
      comparable && h('span.sample', {}, `largest difference ${fixed(difference, 3)}`));
  }
}
