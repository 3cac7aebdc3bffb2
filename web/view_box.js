// A box over the layers and its figures: error or lighting executions inside, their share of the whole, a histogram.
import {h, replace} from './dom.js';
import {count, fixed, missing, shortCount, significant} from './format.js';
import {ask} from './pixels.js';
import {clamp} from './view_geometry.js';
import {isMap, source, valueText} from './view_state.js';

/** The box between two pixels, both inside. */
export function boxBetween(from, to, {width, height}) {
  const side = (a, b, size) => [clamp(Math.min(a, b), 0, size - 1), clamp(Math.max(a, b), 0, size - 1)];
  const [left, right] = side(from.x, to.x, width);
  const [top, bottom] = side(from.y, to.y, height);
  return {x: left, y: top, width: right - left + 1, height: bottom - top + 1};
}

/** The middle third of a part. */
export function boxInMiddle(part) {
  const [width, height] = [Math.max(1, Math.round(part.width / 3)), Math.max(1, Math.round(part.height / 3))];
  return {x: part.x + Math.floor((part.width - width) / 2), y: part.y + Math.floor((part.height - height) / 2), width, height};
}

/** What of a box lies in an image. */
function inside(box, size) {
  const [x, y] = [clamp(box.x, 0, size.width - 1), clamp(box.y, 0, size.height - 1)];
  return {x, y, width: clamp(box.width, 1, size.width - x), height: clamp(box.height, 1, size.height - y)};
}

export class BoxPanel {
  element = h('section.box-panel', {'aria-live': 'polite'});
  #close;
  #turn = 0;

  constructor(close) {
    this.#close = close;
  }

  /** Measures the layers within the box; without one, or a size, shows nothing. */
  async measure(wanted, size, layers) {
    const mine = ++this.#turn;
    if (!wanted || !size) return this.element.hasChildNodes() && replace(this.element);
    const box = inside(wanted, size);
    let figures;
    try {
      figures = await ask('box', {box, layers: layers.map((layer) => ({...source(layer), reference: layer.reference && source(layer.reference), high: layer.scale?.maximum ?? 1}))});
    } catch (error) {
      return replace(this.element, h('p.problem', {}, error.message));
    }
    if (mine !== this.#turn) return;
    replace(this.element, h('div.section-head', {}, h('h3', {}, `Box at ${box.x}, ${box.y} of ${box.width}×${box.height} pixels`),
      h('button.plain', {type: 'button', onclick: this.#close}, 'Close the box')),
    h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'Figures of the box'}, h('table.box-figures', {}, h('thead', {}, h('tr', {},
      ['Layer', 'Of', 'Mean', 'Largest', 'Sum', 'Share of the whole', 'Histogram'].map((title) => h('th', {scope: 'col'}, title)))),
    h('tbody', {}, layers.map((layer, i) => figures[i] && figuresRow(layer, figures[i]))))));
  }
}

function figuresRow(layer, figures) {
  const counted = isMap(layer) && layer.scale?.discrete;
  const sum = shortCount(figures.sum) === missing ? missing : counted ? count(figures.sum) : significant(figures.sum, 4);
  return h('tr', {}, h('th', {scope: 'row'}, layer.label), h('td', {}, isMap(layer) ? layer.scale?.unit || 'value' : 'error'),
    [valueText(figures.mean, 'half'), valueText(figures.largest, 'half'), sum, `${fixed(100 * figures.share, 2)} %`].map((text) => h('td.number', {}, text)), h('td', {}, histogram(figures)));
}

function histogram({histogram: steps, high}) {
  const most = Math.max(...steps, 1);
  return h('span.steps', {role: 'img', 'aria-label': `Pixels from 0 to ${valueText(high, 'half')}: ${steps.join(', ')}`}, steps.map((value) => {
    const bar = h('i', {});
    bar.style.height = `${value > 0 ? Math.max(6, (100 * value) / most) : 0}%`;
    return bar;
  }));
}
