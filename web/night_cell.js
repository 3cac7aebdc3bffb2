// A cell of a night: what was judged, the baseline's image beside tonight's and another night's, and the story of a pixel.
import {blobUrl, get} from './api.js';
import {legend} from './colour_scales.js';
import {CompareView} from './compare_view.js';
import {announce, field, h, replace} from './dom.js';
import {bytes, count, fixed, scientific, significant, when} from './format.js';
import {PixelStory} from './pixel_story.js';
import {panelParts, picturePart, printed} from './report.js';
import {layerOf} from './run_layers.js';
import {statusPill} from './runs_page.js';
import {trendAddress} from './trends_page.js';
import {loadView, saveView} from './view_address.js';

const differenceScale = {map: 'magma', maximum: 0.25, description: 'largest absolute difference of the sRGB channels to the baseline', unit: ''};

export class NightCell {
  element = h('section.night-cell', {'aria-live': 'polite'});
  view;
  #night;
  #registry;
  #address;
  #story = new PixelStory((pixel) => this.#choosePixel(pixel));
  #details = null;
  #frame = null;      // of #details
  #other = null;      // the same cell of another night: {night, frames}
  #parts = {};        // {frames, nights: selects; pictures, scale, figures: elements}
  #turn = 0;

  /** Of `night`; what is looked at is in `address`, which restores it. */
  constructor(night, registry, address) {
    [this.#night, this.#registry, this.#address] = [night, registry, address];
    this.view = new CompareView((state) => saveView(address, state));
    this.view.restore(loadView(address));
    this.view.element.addEventListener('pixelchosen', ({detail: {x, y}}) => this.#choosePixel({x, y}));
  }

  /** Opens a cell of the night; what the address says of frame, other night and pixel when it is `restored`. */
  async open(cell, restored = false) {
    const mine = ++this.#turn;
    let details;
    try {
      details = await get(`/api/nights/${this.#night.id}/cells/${cell.id}`);
    } catch (error) {
      return replace(this.element, h('p.problem', {role: 'alert'}, error.message));
    }
    if (mine !== this.#turn) return;  // another cell was opened meanwhile
    if (!restored) this.#story.close();
    this.#details = details;
    this.#build(cell.id);
    const wanted = restored ? details.frames.find(({frame}) => frame === this.#address.number('frame', -1)) : null;
    this.#frame = wanted ?? details.frames.find(({difference}) => difference) ?? details.frames[0];  // the first that differs says most
    const other = restored ? this.#address.number('of', 0) : 0;
    this.#other = other ? await this.#cellOf(other).catch(() => null) : null;
    this.#listNights();
    this.#draw();
    const [x, y] = restored ? this.#address.text('pixel').split(',').map(Number) : [];
    if (Number.isInteger(x) && Number.isInteger(y)) this.#choosePixel({x, y});
    else this.element.scrollIntoView({block: 'nearest'});
  }

  #build(id) {
    const {capture, technique, status, gates, frames: list} = this.#details;
    const frames = h('select', {onchange: () => this.#show(list[Number(frames.value)])}, list.map(({frame, difference}, i) => h('option', {value: i}, `${frame}${difference ? ', differs' : ''}`)));
    const nights = h('select', {onchange: () => this.#compareWith(Number(nights.value))}, h('option', {value: 0}, 'no other night'));
    this.#parts = {frames, nights, pictures: h('div.pictures', {}), scale: h('div', {}), figures: h('div', {})};
    this.#address.set({cell: id});
    replace(this.element,
      h('div.section-head', {}, h('h2', {}, `${capture}, ${technique}`), statusPill(status), list.length > 1 && field('frame', frames), field('and of', nights),
        h('span.spacer', {}), h('a.button', {href: trendAddress(this.#night.name, capture, technique)}, 'Trend')),
      gatesTable(gates), this.#parts.pictures, this.#parts.scale, this.#parts.figures, this.view.element, this.#story.element);
  }

  #show(frame) {
    if (!frame) return;
    this.#frame = frame;
    this.#story.close();
    this.#draw();
  }

  /** The frame after this one, or before it. */
  step(by) {
    const {frames = []} = this.#details ?? {};
    this.#show(frames[frames.indexOf(this.#frame) + by]);
  }

  async #compareWith(night) {
    try {
      this.#other = night ? await this.#cellOf(night) : null;
      if (night && !this.#other) announce(`Night ${night} does not have this cell`);
    } catch (error) {
      announce(error.message);
    }
    this.#draw();
  }

  #draw() {
    const {frames, nights, pictures, scale, figures} = this.#parts;
    const frame = this.#frame;
    const index = Math.max(0, this.#details.frames.indexOf(frame));
    frames.value = index;
    nights.value = this.#other?.night ?? 0;
    this.#address.set({frame: this.#details.frames.length > 1 ? frame?.frame : null, of: this.#other?.night});
    replace(pictures, picture('baseline', frame?.baseline?.images.image, 'The baseline does not have it.'),
      picture('tonight', frame?.tonight?.images.image, 'It was not replayed.'),
      picture('difference', frame?.difference, frame?.tonight && frame?.baseline ? 'The images are equal.' : 'There is nothing to compare.'));
    replace(scale, frame?.difference && legend(differenceScale));
    replace(figures, frame && figuresTable(frame.baseline, frame.tonight));
    const layers = this.#layers();
    this.view.element.hidden = layers.length === 0;
    if (layers.length > 0) this.view.setLayers(layers);
  }

  async #listNights() {
    const {nights: select} = this.#parts;
    const {name, id: own} = this.#night;
    try {
      const {nights} = await get(`/api/nights?name=${encodeURIComponent(name)}&limit=50`);
      for (const {id, started_utc: started} of nights) if (id !== own) select.append(h('option', {value: id}, `night ${id}, ${when(started)}`));
      select.value = this.#other?.night ?? 0;
    } catch {
      // Then there is none to choose.
    }
  }

  async #cellOf(night) {
    const {capture, technique} = this.#details;
    const {cells} = await get(`/api/nights/${night}`);
    const cell = cells.find((candidate) => candidate.capture === capture && candidate.technique === technique);
    return cell ? {night, frames: (await get(`/api/nights/${night}/cells/${cell.id}`)).frames} : null;
  }

  // Baseline and tonight, the image of another night, the reference and tonight's maps.
  #layers() {
    const [frame, other] = [this.#frame, this.#other];
    const layers = [];
    const add = (result, label, ...roles) => {
      if (!result) return;
      const row = {label, entry: this.#registry.find(({name}) => name === result.technique)};
      for (const role of roles) layers.push(layerOf(`${label}:${role}`, row, result, role));
    };
    add(frame?.baseline, 'baseline', 'image');
    add(frame?.tonight, 'tonight', 'image');
    add(other?.frames.find((candidate) => candidate.frame === frame?.frame)?.tonight, `night ${other?.night}`, 'image');
    if (!other) add(frame?.tonight, 'tonight', 'reference');
    add(frame?.baseline, 'baseline', 'error');
    add(frame?.tonight, 'tonight', 'error', 'shading');
    return layers.filter(Boolean);
  }

  // What tonight's technique does there, as the service's program does it; null when the story was closed.
  async #choosePixel(pixel) {
    this.#address.set({pixel: pixel && `${pixel.x},${pixel.y}`});
    this.view.mark(pixel);
    const result = this.#frame?.tonight ?? this.#frame?.baseline;
    if (!pixel || !result) return;
    const {hash, head} = this.#night.captures.find(({name}) => name === this.#details.capture);
    const {technique, parameters, samples, width, height} = result;
    await this.#story.show({hash, technique, parameters, samples, frame: this.#frame.frame, width, height, point_lights: await this.#ownLights(hash, head)}, pixel);
  }

  // The lights that a night was told to have, if any: others than were recorded.
  async #ownLights(hash, head) {
    try {
      const {summary} = await get(`/api/captures/${hash}`);
      return head && summary.frames[0]?.point_lights !== head.point_lights ? head.point_lights : undefined;
    } catch {
      return undefined;  // the story says that there is no such capture
    }
  }

  /** Parts of a report: what is seen of the cell. */
  get report() {
    if (!this.#details) return [];
    const {capture, technique, status, gates} = this.#details;
    const labels = this.view.layers.map(({label}, i) => `${i + 1} ${label}`).join(', ');
    return [{title: `${capture}, ${technique}: ${status}`, html: printed(gatesTable(gates))}, {html: printed(this.#parts.pictures) + printed(this.#parts.scale) + printed(this.#parts.figures)},
      picturePart(this.view, `Frame ${this.#frame?.frame}; ${this.view.state.mode}; layers ${labels}`), ...panelParts(this.view),
      !this.#story.element.hidden && {html: printed(this.#story.element)}].filter(Boolean);
  }

  close() {
    ++this.#turn;
    this.view.close();
  }
}

export function picture(title, blob, absent) {
  return h('figure', {}, h('figcaption', {}, title),
    blob ? h('a', {href: blobUrl(blob)}, h('img', {src: blobUrl(blob), alt: title})) : h('div.none', {}, absent));
}

function gatesTable(gates) {
  return h('div.scroll', {}, h('table.gates', {}, h('thead', {}, h('tr', {}, ['Gate', 'Outcome', 'Why'].map((name) => h('th', {scope: 'col'}, name)))),
    h('tbody', {}, gates.map((gate) => h('tr', {},
      h('th', {scope: 'row'}, gate.gate), h('td', {}, statusPill(gate.outcome)), h('td', {}, gate.detail))))));
}

const figures = [
  ['published bytes per pixel', (r) => significant(r.memory.paper_bytes_per_pixel, 5)],
  ['fitted bytes per pixel', (r) => significant(r.memory.fitted_bytes_per_pixel, 5)],
  ['allocated', (r) => bytes(r.memory.allocated_bytes)],
  ['lighting executions', (r) => count(r.shading.executions)],
  ['ms', (r) => fixed(r.ms.total, 2)],
  ['MSE', (r) => scientific(r.error.mse ?? NaN)],
  ['FLIP, mean', (r) => fixed(r.error.flip_mean ?? NaN, 5)],
];

function figuresTable(before, now) {
  const counters = [...new Set([before, now].flatMap((result) => Object.keys(result?.counters ?? {})))];
  const rows = [...figures, ...counters.map((name) => [name, (r) => count(r.counters[name])])].map(([name, text]) =>
    [name, before ? text(before) : '–', now ? text(now) : '–']);
  return h('details', {}, h('summary', {}, 'Figures of this frame'), h('div.scroll', {}, h('table', {}, h('thead', {}, h('tr', {},
    h('th', {scope: 'col'}, ''), h('th.number', {scope: 'col'}, 'Baseline'), h('th.number', {scope: 'col'}, 'Tonight'))),
  h('tbody', {}, rows.map(([name, a, b]) => h('tr', {class: a === b ? '' : 'differs'},
    h('th', {scope: 'row'}, name), h('td.number', {}, a), h('td.number', {}, b)))))));
}
