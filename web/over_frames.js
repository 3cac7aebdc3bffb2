// A measure over the frames of a run, a line for each technique (uPlot), and as SVG for files.
import {h, replace} from './dom.js';
import {download} from './files.js';
import {Later} from './later.js';
import {measureOf, measures, measureTitle} from './measures.js';
import {measureOptions} from './scatter.js';
import {axes, colours, s, svgText, tickText} from './svg.js';

let library = null;
// Fetched when the first plot is drawn: the first page does without.
export function loadPlots() {
  library ??= new Promise((resolve, reject) => {
    document.head.append(h('link', {rel: 'stylesheet', href: '/uplot.min.css'}),
      // It has run in a task of its own when the first plot is made.
      h('script', {src: '/uplot.min.js', onload: () => setTimeout(() => resolve(window.uPlot)), onerror: () => reject(new Error('the plots could not be loaded'))}));
  });
  return library;
}

const plotHeight = 280;
const choices = measures.filter(({key}) => !['ratio', 'psnr'].includes(key));
const colourOf = (i) => colours[i % colours.length];

/** The lines as SVG: `series` [{label, values, colour}] over `frames`. */
export function linesSvg(frames, series, title, log) {
  const [width, height] = [900, 320];
  const {frame, x, y} = axes({width, height, xs: frames, ys: series.flatMap(({values}) => values), logX: false, logY: log, titleX: 'Frame', titleY: title});
  const path = (values) => {
    let text = '';
    let pen = 'M';
    values.forEach((value, i) => {
      if (value === null || !y.shows(value)) pen = 'M';
      else {
        text += `${pen}${x.place(frames[i]).toFixed(1)},${y.place(value).toFixed(1)}`;
        pen = 'L';
      }
    });
    return text;
  };
  return s('svg', {viewBox: `0 0 ${width} ${height + 20 * Math.ceil(series.length / 4)}`, role: 'img', 'aria-label': `${title} over frames`}, frame,
    series.map(({values, colour}) => s('path', {d: path(values), fill: 'none', stroke: colour, 'stroke-width': 1.8})),
    series.map(({label, colour}, i) => {
      const [left, top] = [66 + (i % 4) * 205, height + 6 + 20 * Math.floor(i / 4)];
      return [s('rect', {x: left, y: top - 9, width: 11, height: 11, fill: colour}), s('text', {x: left + 16, y: top, 'font-size': 11.5, fill: 'currentColor', 'font-family': 'system-ui, sans-serif'}, label)];
    }));
}

export class OverFrames {
  #place = h('div.lines', {role: 'img', 'aria-label': 'A measure over the frames'});
  #keys = h('div.series-keys', {role: 'group', 'aria-label': 'Lines'});
  #chosen;
  #on;
  #plot = null;
  #made = '';          // what the plot was made for; other data go into the same one
  #closed = false;
  #hidden;             // labels of lines that are off
  #data = {frames: [], series: []};
  #frame = 0;
  #frameLine = h('div.frame-line', {});
  #keysFor = '';       // what the keys were drawn for
  #later = new Later(this.#place, () => this.#render());
  #resize = new ResizeObserver(() => this.#plot?.setSize({width: this.#place.clientWidth, height: plotHeight}));

  /** `chosen`: {measure, log, hidden: labels of lines that are off}; `on.change(chosen)`, `on.frame(frame)`. */
  constructor(chosen, name, on) {
    this.#chosen = chosen;
    this.#hidden = new Set(chosen.hidden);
    this.#on = on;
    this.element = h('div', {}, h('div.choices', {},
      h('label', {}, h('span', {}, 'Show'), h('select', {'aria-label': 'Measure over frames', onchange: (event) => this.#choose({measure: event.target.value})}, measureOptions(chosen.measure, choices))),
      h('label.check', {}, h('input', {type: 'checkbox', checked: chosen.log, onchange: (event) => this.#choose({log: event.target.checked})}), 'logarithmic'),
      h('span.spacer', {}), h('button', {type: 'button', onclick: () => download(`${name}-${this.#chosen.measure}-frames.svg`, 'image/svg+xml', this.text())}, 'SVG')),
    this.#keys, this.#place);
    this.#resize.observe(this.#place);
  }

  get title() {
    return measureTitle(measureOf(this.#chosen.measure));
  }

  #choose(change) {
    Object.assign(this.#chosen, change);
    this.#on.change(this.#chosen);
    this.#render();
  }

  /** `series`: [{label, of(measureKey) -> values by frame, null where there is none}]. */
  draw(frames, series, frame) {
    this.#data = {frames, series: series.map((line, i) => ({...line, colour: colourOf(i)}))};
    this.#frame = frame;
    this.#later.ask();
  }

  setFrame(frame) {
    this.#frame = frame;
    this.#placeLine();
  }

  #placeLine() {
    if (this.#plot) this.#frameLine.style.left = `${Math.round(this.#plot.valToPos(this.#frame, 'x'))}px`;
  }

  #drawKeys() {
    const {series} = this.#data;
    const keysFor = JSON.stringify([series.map(({label}) => label), [...this.#hidden]]);
    if (keysFor === this.#keysFor) return;
    this.#keysFor = keysFor;
    replace(this.#keys, series.map(({label, colour}) => {
      const key = h('i.key', {});
      key.style.background = colour;
      return h('button.series-key', {type: 'button', 'aria-pressed': String(!this.#hidden.has(label)), onclick: () => {
        if (!this.#hidden.delete(label)) this.#hidden.add(label);
        this.#choose({hidden: [...this.#hidden]});
      }}, key, label);
    }));
  }

  async #render() {
    this.#drawKeys();
    let UPlot;
    try {
      UPlot = await loadPlots();
    } catch (error) {
      return replace(this.#place, h('p.problem', {}, error.message));
    }
    if (this.#closed) return;
    const {frames, series} = this.#data;
    const data = [frames, ...series.map((line) => this.#values(line))];
    this.#place.dataset.drawn = this.#chosen.measure;
    if (data.slice(1).every((values) => values.every((value) => value === null))) {
      this.#plot?.destroy();
      this.#plot = null;
      return replace(this.#place, h('p.quiet', {}, 'Nothing is measured yet.'));
    }
    const made = JSON.stringify([series.map(({label}) => label), this.#chosen, [...this.#hidden], document.documentElement.dataset.theme]);
    if (this.#plot && this.#made === made) return this.#plot.setData(data);
    this.#plot?.destroy();
    this.#made = made;
    replace(this.#place);
    this.#plot = new UPlot(this.#options(), data, this.#place);
    this.#plot.over.append(this.#frameLine);
    this.#placeLine();
  }

  // Of the plot, as uPlot wants them.
  #options() {
    const {log, measure} = this.#chosen;
    const {frames, series} = this.#data;
    const style = getComputedStyle(document.documentElement);
    const [ink, line] = [style.getPropertyValue('--ink').trim(), style.getPropertyValue('--line').trim()];
    const axis = {stroke: ink, grid: {stroke: line, width: 1}, ticks: {stroke: line}};
    return {
      width: this.#place.clientWidth || 600, height: plotHeight, legend: {show: false}, cursor: {drag: {x: false, y: false}, points: {size: 6}},
      scales: {x: {time: false}, y: log ? {distr: 3} : {range: (_, low, high) => [Math.min(0, low ?? 0), (high ?? 1) * 1.06 || 1]}},
      axes: [{...axis, label: 'Frame', labelSize: 22, size: 38, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10000]}, {...axis, label: measureTitle(measureOf(measure)), labelSize: 22, size: 66, values: (_, ticks) => ticks.map((v) => (v === null ? '' : tickText(v)))}],
      series: [{}, ...series.map(({label, colour}) => ({label, stroke: colour, width: 1.6, show: !this.#hidden.has(label), spanGaps: false, points: {show: frames.length < 2}}))],
      hooks: {
        draw: [() => this.#placeLine()],
        ready: [(plot) => plot.over.addEventListener('click', () => {
          if (plot.cursor.idx !== null) this.#on.frame(this.#data.frames[plot.cursor.idx]);
        })],
      },
    };
  }

  #values({of}) {
    return of(this.#chosen.measure).map((value) => (Number.isFinite(value) && !(this.#chosen.log && value <= 0) ? value : null));
  }

  text() {
    const lines = this.#data.series.filter(({label}) => !this.#hidden.has(label)).map((line) => ({...line, values: this.#values(line)}));
    return svgText(linesSvg(this.#data.frames, lines, this.title, this.#chosen.log));
  }

  close() {
    this.#closed = true;
    this.#later.close();
    this.#resize.disconnect();
    this.#plot?.destroy();
  }
}
