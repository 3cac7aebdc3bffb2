// Draws what a comparison shows: the pictures, what lies over them, the minimap and the magnifier.
import {h, replace, setAttribute} from './dom.js';
import {ask} from './pixels.js';
import {source, valueText} from './view_state.js';

const gridFrom = 12;      // CSS pixels per image pixel from which pixel borders are drawn
const valuesFrom = 56;    // and their values
const magnified = {pixels: 17, size: 11};  // of the magnifier: image pixels across, and each one's CSS pixels

export class ViewPainter {
  canvas = h('canvas.view-canvas', {tabindex: 0, role: 'application', 'aria-label': 'Layers of the frame'});
  minimap = h('canvas.minimap', {width: 160, height: 90, 'aria-hidden': true});
  #labels = h('div.view-labels', {});
  #handle = h('div.wipe-handle', {'aria-hidden': true}, h('span', {}, '⇔'));
  #magnifier = h('canvas.magnifier', {width: magnified.pixels * magnified.size, height: magnified.pixels * magnified.size, 'aria-hidden': true, hidden: true});
  #geometry;
  #state;
  #pictures = [];
  #labelled = '';       // what the labels were drawn for
  #region = null;       // values drawn into large pixels: {key, rows, x, y}
  #redraw;
  marked = null;        // {x, y}: the pixel whose story is told

  /** `redraw()` is called when something that was awaited has come. */
  constructor(geometry, state, redraw) {
    this.#geometry = geometry;
    this.#state = state;
    this.#redraw = redraw;
    this.element = h('div.view-stage', {}, this.canvas, this.#handle, this.#labels, this.minimap, this.#magnifier);
  }

  /** `pictures`: [{bitmap, label, layers}]; `layerCount` of which they are some. */
  draw(pictures, layerCount, pointer) {
    this.#pictures = pictures;
    const context = this.canvas.getContext('2d');
    if (pictures.length === 0) {
      context.clearRect(0, 0, this.canvas.width, this.canvas.height);
      this.#labelled = '';
      return replace(this.#labels);
    }
    const geometry = this.#geometry;
    const {width, height} = geometry.canvas;
    const density = window.devicePixelRatio || 1;
    const [w, t] = [Math.round(width * density), Math.round(height * density)];
    if (this.canvas.width !== w || this.canvas.height !== t) Object.assign(this.canvas, {width: w, height: t});
    context.setTransform(density, 0, 0, density, 0, 0);
    context.clearRect(0, 0, width, height);
    const cells = geometry.cells();
    const {wiped, line} = geometry;
    if (wiped) {
      this.#drawPicture(context, pictures[0], cells[0], 0, line);
      this.#drawPicture(context, pictures[1], cells[0], line, width);
    } else {
      cells.forEach((cell, i) => this.#drawPicture(context, pictures[i], cell, 0, cell.width));
    }
    cells.forEach((cell, i) => this.#drawOver(context, cell, pictures[i]));
    this.#handle.hidden = !wiped;
    this.#handle.style.left = `${line}px`;
    this.canvas.style.touchAction = geometry.whole ? 'pan-y' : 'none';  // one finger scrolls the page over a whole picture
    this.#drawLabels(cells, layerCount);
    this.#drawMinimap(cells[0]);
    this.drawMagnifier(pointer);
  }

  #drawPicture(context, picture, cell, from, to) {
    if (!picture || to <= from) return;
    const place = this.#geometry.placement(cell);
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
  #drawOver(context, cell, picture) {
    const place = this.#geometry.placement(cell);
    context.save();
    context.beginPath();
    context.rect(cell.x, cell.y, cell.width, cell.height);
    context.clip();
    context.translate(cell.x, cell.y);
    if (place.scale >= gridFrom) this.#drawGrid(context, place, cell);
    if (place.scale >= valuesFrom) this.#drawValues(context, place, cell, picture?.layers[0]);
    if (this.marked) this.#drawMark(context, place);
    const {box} = this.#state;
    if (box) {
      for (const [colour, width] of [['#000', 4], ['#ffd23f', 2]]) {
        context.strokeStyle = colour;
        context.lineWidth = width;
        context.strokeRect(place.x + box.x * place.scale, place.y + box.y * place.scale, box.width * place.scale, box.height * place.scale);
      }
    }
    context.restore();
    context.fillStyle = '#fff';
    if (cell.x > 0) context.fillRect(cell.x - 0.5, cell.y, 1, cell.height);
    if (cell.y > 0) context.fillRect(cell.x, cell.y - 0.5, cell.width, 1);
  }

  // A frame around the marked pixel, and around that one that is seen however small the pixel is.
  #drawMark(context, place) {
    const [x, y] = [place.x + this.marked.x * place.scale, place.y + this.marked.y * place.scale];
    const around = Math.max(0, (11 - place.scale) / 2);
    for (const [colour, width] of [['#000', 4], ['#fff', 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.strokeRect(x - around, y - around, place.scale + 2 * around, place.scale + 2 * around);
    }
  }

  #drawGrid(context, place, cell) {
    const part = this.#geometry.part(cell);
    const {width, height} = this.#geometry.size;
    context.strokeStyle = 'rgb(128 128 128 / 0.35)';
    context.lineWidth = 1;
    context.beginPath();
    for (let x = part.x; x <= part.x + part.width; ++x) {
      const at = Math.round(place.x + x * place.scale) + 0.5;
      context.moveTo(at, Math.max(0, place.y));
      context.lineTo(at, Math.min(cell.height, place.y + height * place.scale));
    }
    for (let y = part.y; y <= part.y + part.height; ++y) {
      const at = Math.round(place.y + y * place.scale) + 0.5;
      context.moveTo(Math.max(0, place.x), at);
      context.lineTo(Math.min(cell.width, place.x + width * place.scale), at);
    }
    context.stroke();
  }

  // The numbers of the layer that is seen, in its pixels.
  #drawValues(context, place, cell, layer) {
    const part = this.#geometry.part(cell);
    if (!layer || part.width * part.height > 1200 || part.width * part.height === 0) return;
    const key = `${layer.url} ${Object.values(part)}`;
    if (this.#region?.key !== key) return this.#askValues(key, layer, part);
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

  #askValues(key, layer, part) {
    if (this.#region?.asked === key) return;
    this.#region = {asked: key};
    ask('region', {layer: source(layer), ...part}).then((rows) => {
      this.#region = {key, rows, ...part, type: layer.kind === 'display' ? 'byte' : layer.scale?.discrete ? 'uint' : 'half'};
      this.#redraw();
    }, () => {});
  }

  #drawLabels(cells, layerCount) {
    const {wiped, line, canvas: {width}} = this.#geometry;
    const texts = this.#pictures.map(({label}) => label);
    setAttribute(this.canvas, 'aria-label', texts.join(wiped ? ' against ' : ', '));
    const label = (text, side) => ({text, side, left: 0, top: 0});
    let labels;
    if (wiped) labels = [line >= 30 && label(texts[0], 'left'), width - line >= 30 && label(texts[1], 'right')].filter(Boolean);
    else if (cells.length === 1) labels = [label(`${this.#state.mode === 'flip' ? `${this.#state.a + 1} of ${layerCount}: ` : ''}${texts[0]}`, 'left')];
    else labels = cells.map((cell, i) => ({text: texts[i], side: '', left: cell.x + 8, top: cell.y + 8}));
    const labelled = JSON.stringify(labels);
    if (labelled === this.#labelled) return;
    this.#labelled = labelled;
    replace(this.#labels, labels.map(({text, side, left, top}) => {
      const element = h('span.view-label', {class: side}, text);
      if (!side) Object.assign(element.style, {left: `${left}px`, top: `${top}px`});
      return element;
    }));
  }

  #drawMinimap(cell) {
    const {whole, size: {width, height}} = this.#geometry;
    this.minimap.hidden = whole;
    if (whole) return;
    const scale = Math.min(160 / width, 110 / height);
    Object.assign(this.minimap, {width: Math.round(width * scale), height: Math.round(height * scale)});
    const context = this.minimap.getContext('2d');
    context.drawImage(this.#pictures[0].bitmap, 0, 0, this.minimap.width, this.minimap.height);
    const place = this.#geometry.placement(cell);
    context.lineWidth = 2;
    context.strokeStyle = '#ffd23f';
    context.strokeRect((-place.x / place.scale) * scale, (-place.y / place.scale) * scale, (cell.width / place.scale) * scale, (cell.height / place.scale) * scale);
  }

  /** What is under the pointer, or in the middle, eleven times as large. */
  drawMagnifier(pointer) {
    this.#magnifier.hidden = !this.#state.magnify || this.#pictures.length === 0;
    if (this.#magnifier.hidden) return;
    const {canvas} = this.#geometry;
    const under = this.#geometry.under(pointer ?? {x: canvas.width / 2, y: canvas.height / 2});
    const {pixels, size} = magnified;
    const middle = (pixels - 1) / 2;
    const context = this.#magnifier.getContext('2d');
    context.imageSmoothingEnabled = false;
    context.fillStyle = '#1a1d22';
    context.fillRect(0, 0, pixels * size, pixels * size);
    const picture = this.#pictures[Math.min(under.index, this.#pictures.length - 1)].bitmap;
    context.drawImage(picture, (middle - under.x) * size, (middle - under.y) * size, picture.width * size, picture.height * size);
    context.strokeStyle = '#ffd23f';
    context.lineWidth = 2;
    context.strokeRect(middle * size, middle * size, size, size);
  }

  /** What is on the screen as a picture of its own, for reports. */
  pictureUrl() {
    return this.#pictures.length > 0 ? this.canvas.toDataURL('image/png') : null;
  }
}
