// Any measure against any other: a point for each row, a line through each technique's settings, and the front of those that
// nothing beats in both. A point selects its row.
import {h, replace} from './dom.js';
import {download} from './files.js';
import {placeLabels} from './labels.js';
import {Later} from './later.js';
import {measureOf, measures, measureTitle, paretoFront, valueOf} from './measures.js';
import {axes, colours, s, svgText} from './svg.js';

const [width, height] = [900, 420];

/** Options of a select of measures. */
export const measureOptions = (chosen, list = measures) => list.map((measure) => h('option', {value: measure.key, selected: measure.key === chosen}, measureTitle(measure)));

/** The drawing: `rows` as of the table, `onSelect(row)`. */
export function scatterSvg(rows, {x: keyX, y: keyY, logX, logY, baseline}, onSelect) {
  const points = rows.map((row) => ({row, x: valueOf(row, keyX, baseline), y: valueOf(row, keyY, baseline)}));
  const [mx, my] = [measureOf(keyX), measureOf(keyY)];
  const {frame, x, y, box} = axes({width, height, xs: points.map((p) => p.x), ys: points.map((p) => p.y), logX, logY, titleX: measureTitle(mx), titleY: measureTitle(my)});
  const shown = points.filter((p) => x.shows(p.x) && y.shows(p.y));
  const families = new Map();
  for (const point of shown) {
    const name = `${point.row.technique} ${point.row.run}`;
    families.set(name, [...(families.get(name) ?? []), point]);
  }
  const colourOf = (row) => colours[row.family % colours.length];
  const at = (p) => `${x.place(p.x).toFixed(1)},${y.place(p.y).toFixed(1)}`;
  const front = paretoFront(shown.map((p) => p.row), keyX, keyY, baseline);
  const frontPoints = front.map((row) => shown.find((p) => p.row === row));
  const places = shown.map((p) => ({x: x.place(p.x), y: y.place(p.y), text: p.row.label}));
  const labels = placeLabels(places, {left: box.left, right: width, top: 0, bottom: box.bottom});
  return s('svg', {viewBox: `0 0 ${width} ${height}`, width, height, role: 'group', 'aria-label': `${measureTitle(my)} against ${measureTitle(mx)}`}, frame,
    frontPoints.length > 1 && s('polyline', {class: 'front', points: frontPoints.map(at).join(' '), fill: 'none', stroke: 'currentColor', 'stroke-width': 5, 'stroke-opacity': 0.18, 'stroke-linejoin': 'round'}),
    [...families.values()].filter((family) => family.length > 1).map((family) => s('polyline', {class: 'family', points: [...family].sort((p, q) => p.x - q.x).map(at).join(' '),
      fill: 'none', stroke: colourOf(family[0].row), 'stroke-width': 1.5, 'stroke-dasharray': family[0].row.run === rows[0].run ? null : '4 3'})),
    labels.map((label, i) => label && label.dy !== 0 && s('line', {x1: places[i].x, y1: places[i].y, x2: label.x, y2: label.y - 4, stroke: 'currentColor', 'stroke-opacity': 0.35})),
    shown.map((p, i) => {
      const best = front.includes(p.row);
      const select = (event) => {
        event.preventDefault();
        onSelect?.(p.row.select);
      };
      const {x: px, y: py} = places[i];
      const label = labels[i];
      return s('g', {class: 'point', 'data-row': p.row.select, ...(onSelect ? {tabindex: 0, role: 'button', 'aria-pressed': String(Boolean(p.row.selected)),
        'aria-label': `${p.row.label}: ${measureTitle(mx)} ${mx.text(p.x)}, ${measureTitle(my)} ${my.text(p.y)}${best ? ', on the front' : ''}`,
        onclick: select, onkeydown: (event) => ['Enter', ' '].includes(event.key) && select(event)} : {})},
      s('circle', {cx: px, cy: py, r: 13, fill: 'transparent'}),
      s('circle', {cx: px, cy: py, r: p.row.selected ? 7.5 : 5.5, fill: colourOf(p.row), stroke: 'currentColor', 'stroke-width': best ? 2 : 0.5}),
      label && s('text', {x: label.x, y: label.y, 'font-size': 11.5, fill: 'currentColor', 'font-family': 'system-ui, sans-serif', 'text-anchor': label.anchor}, p.row.label),
      s('title', {}, p.row.label));
    }));
}

export class Scatter {
  #drawing = h('div.plot', {});
  #controls = h('div.choices', {});
  #rows = [];
  #baseline = null;
  #chosen;
  #on;
  #later = new Later(this.#drawing, () => this.#render());

  /** `chosen`: {x, y, logX, logY}; `on.change(chosen)`, `on.select(row)`; `name` begins the names of files. */
  constructor(chosen, name, on) {
    this.#chosen = chosen;
    this.#on = on;
    const select = (key, label) => h('label', {}, h('span', {}, label), h('select', {'aria-label': key === 'x' ? 'Measure across' : 'Measure upwards', onchange: (event) => this.#choose({[key]: event.target.value})}, measureOptions(chosen[key])));
    const check = (key, label) => h('label.check', {}, h('input', {type: 'checkbox', checked: chosen[key], onchange: (event) => this.#choose({[key]: event.target.checked})}), label);
    replace(this.#controls, select('y', 'Show'), select('x', 'against'), check('logX', 'logarithmic across'), check('logY', 'logarithmic upwards'), h('span.spacer', {}),
      h('button', {type: 'button', onclick: () => download(`${name}-${this.#chosen.x}-${this.#chosen.y}.svg`, 'image/svg+xml', this.text())}, 'SVG'));
    this.element = h('div', {}, this.#controls, this.#drawing);
  }

  get controls() {
    return this.#controls;
  }

  #choose(change) {
    Object.assign(this.#chosen, change);
    this.#on.change(this.#chosen);
    this.#render();
  }

  draw(rows, baseline) {
    [this.#rows, this.#baseline] = [rows, baseline];
    this.#later.ask();
  }

  close() {
    this.#later.close();
  }

  #render() {
    const [rows, baseline] = [this.#rows, this.#baseline];
    const focused = this.#drawing.contains(document.activeElement) ? document.activeElement.dataset.row : null;
    this.#drawing.dataset.drawn = `${this.#chosen.x} ${this.#chosen.y}`;
    if (!rows.some((row) => row.summary)) return replace(this.#drawing, h('p.quiet', {}, 'Nothing is measured yet.'));
    replace(this.#drawing, scatterSvg(rows, {...this.#chosen, baseline}, this.#on.select));
    if (focused !== null) this.#drawing.querySelector(`[data-row="${focused}"]`)?.focus();
  }

  text() {
    return svgText(scatterSvg(this.#rows, {...this.#chosen, baseline: this.#baseline}, null));
  }
}
