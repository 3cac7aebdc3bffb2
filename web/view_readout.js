// The true values of every layer under the pointer.
import {h, replace} from './dom.js';
import {ask} from './pixels.js';
import {source, valueText} from './view_state.js';

export class ViewReadout {
  element = h('div.readout', {}, 'Point at a pixel for its values.');
  #reading = false;
  #under;

  /** `under()` is the pixel under the pointer, as of ViewGeometry.under(). */
  constructor(under) {
    this.#under = under;
  }

  /** Asks for the values and shows them. `told({x, y, values})` when they are there. */
  async read(state, layers, told) {
    const under = this.#under();
    if (!under?.inside) {
      this.element.textContent = 'Point at a pixel for its values.';
      return;
    }
    if (this.#reading) return;  // the next move asks again
    this.#reading = true;
    const {x, y} = under;
    try {
      const values = await ask('values', {layers: layers.map(source), x, y});
      const {mode, a, b, measure} = state;
      const apart = mode === 'difference' && layers[a] && layers[b] ? await ask('differenceAt', {a: source(layers[a]), b: source(layers[b]), measure, x, y}) : null;
      told({x, y, values: values.map((entry) => entry?.values)});
      this.#show({x, y, layers, values, apart});
    } catch {
      // The layers' own failure is told by the view.
    }
    this.#reading = false;
    const now = this.#under();
    if (now && (now.x !== x || now.y !== y)) this.read(state, layers, told);
  }

  #show({x, y, layers, values, apart}) {
    replace(this.element, h('span.sample', {}, `x ${x}, y ${y}`), values.map((entry, i) => entry && h('span.sample', {}, h('b', {}, `${i + 1} ${layers[i].label}`), ' ',
      entry.values.map((value) => valueText(value, entry.type)).join(' '), (layers[i].scale?.unit || entry.unit) && ` ${layers[i].scale?.unit || entry.unit}`)),
    apart !== null && h('span.sample', {}, h('b', {}, 'difference'), ` ${valueText(apart, 'half')}`));
  }
}
