// Where the pictures of a comparison lie on its canvas. Lengths are in CSS pixels, points of pictures in their pixels.
const maxScale = 128;

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

export class ViewGeometry {
  #state;
  canvas = {width: 1, height: 1};
  size = null;    // {width, height} of the pictures
  number = 0;     // of pictures that are shown

  /** Follows `state` {mode, share, scale, cx, cy}, and changes scale and centre in it. */
  constructor(state) {
    this.#state = state;
  }

  get wiped() {
    return this.#state.mode === 'wipe' && this.number === 2;
  }

  get line() {
    return this.#state.share * this.canvas.width;
  }

  /** Whether the whole picture is seen. */
  get whole() {
    const [cell] = this.cells();
    return this.#state.scale === 0 || this.placement(cell).scale <= this.#fit(cell) * 1.01;
  }

  /** Parts of the canvas, each of which shows whole pictures at the same place and zoom. */
  cells() {
    const {width, height} = this.canvas;
    const number = this.#state.mode === 'side' ? this.number : 1;
    if (number <= 1 || !this.size) return [{x: 0, y: 0, width, height}];
    let best = null;
    for (let columns = 1; columns <= number; ++columns) {
      const rows = Math.ceil(number / columns);
      const fit = Math.min(width / columns / this.size.width, height / rows / this.size.height);
      if (!best || fit > best.fit) best = {columns, rows, fit};
    }
    const [w, t] = [width / best.columns, height / best.rows];
    return Array.from({length: number}, (_, i) => ({x: (i % best.columns) * w, y: Math.floor(i / best.columns) * t, width: w, height: t}));
  }

  #fit(cell) {
    return Math.min(cell.width / this.size.width, cell.height / this.size.height);
  }

  /** Scale, and the picture's top left corner within the cell. */
  placement(cell = this.cells()[0]) {
    const {scale: chosen, cx, cy} = this.#state;
    const scale = chosen > 0 ? chosen : this.#fit(cell);
    const x = chosen > 0 ? cx : this.size.width / 2;
    const y = chosen > 0 ? cy : this.size.height / 2;
    return {scale, x: cell.width / 2 - x * scale, y: cell.height / 2 - y * scale};
  }

  /** The picture's pixels that a cell shows. */
  part(cell = this.cells()[0]) {
    const place = this.placement(cell);
    const x = clamp(Math.floor(-place.x / place.scale), 0, this.size.width);
    const y = clamp(Math.floor(-place.y / place.scale), 0, this.size.height);
    const right = clamp(Math.ceil((cell.width - place.x) / place.scale), 0, this.size.width);
    const bottom = clamp(Math.ceil((cell.height - place.y) / place.scale), 0, this.size.height);
    return {x, y, width: right - x, height: bottom - y};
  }

  /** The pixel under a point of the canvas, and the picture that is seen there: {x, y, cell, index, inside}. */
  under(point) {
    if (!point || !this.size) return null;
    const cells = this.cells();
    const at = Math.max(0, cells.findIndex((c) => point.x >= c.x && point.x < c.x + c.width && point.y >= c.y && point.y < c.y + c.height));
    const cell = cells[at];
    const place = this.placement(cell);
    const x = Math.floor((point.x - cell.x - place.x) / place.scale);
    const y = Math.floor((point.y - cell.y - place.y) / place.scale);
    const index = cells.length > 1 ? at : this.wiped && point.x > this.line ? 1 : 0;
    return {x, y, cell, index, inside: x >= 0 && y >= 0 && x < this.size.width && y < this.size.height};
  }

  /** Brings a point of the picture into the middle. */
  goTo(x, y, scale, cell = this.cells()[0]) {
    Object.assign(this.#state, {scale: clamp(scale, Math.min(this.#fit(cell), 1) / 2, maxScale), cx: clamp(x, 0, this.size.width), cy: clamp(y, 0, this.size.height)});
  }

  /** Zooms so that what is under `point` of the cell, by default its middle, stays where it is. 0: the whole picture. */
  zoomTo(scale, cell = this.cells()[0], point = {x: cell.width / 2, y: cell.height / 2}) {
    if (scale === 0) return Object.assign(this.#state, {scale: 0, cx: null, cy: null});
    const place = this.placement(cell);
    const next = clamp(scale, Math.min(this.#fit(cell), 1) / 2, maxScale);
    this.goTo((point.x - place.x) / place.scale + (cell.width / 2 - point.x) / next, (point.y - place.y) / place.scale + (cell.height / 2 - point.y) / next, next, cell);
  }

  pan(dx, dy) {
    const [cell] = this.cells();
    const {scale, x, y} = this.placement(cell);
    this.goTo((cell.width / 2 - x - dx) / scale, (cell.height / 2 - y - dy) / scale, scale);
  }
}
