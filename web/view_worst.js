// The 50 places where a layer has most, as thumbnails: of a map its own numbers, of an image its error, of a difference of images the difference.
import {announce, h, replace} from './dom.js';
import {ask, bitmap} from './pixels.js';
import {coloured, isMap, source, valueText} from './view_state.js';

const [cut, shown] = [24, 72];  // image pixels across a thumbnail, and its CSS pixels

// The difference that is shown, as an image whose reference is the other one; null of anything else.
function differing({mode, a, b}, layers) {
  const [of, minus] = [layers[a], layers[b]];
  if (mode !== 'difference' || !of || !minus || isMap(of) || isMap(minus)) return null;
  return {...of, reference: minus, label: `${of.label} minus ${minus.label}`};
}

export class WorstPlaces {
  element = h('section.worst-panel', {});
  #goTo;
  #close;
  #listed = '';  // what is listed, or on its way

  /** `goTo(x, y)` is called for a place that was chosen, `close()` for the list to be closed. */
  constructor(goTo, close) {
    this.#goTo = goTo;
    this.#close = close;
  }

  /** Lists them where `state` wants that, of the layer that is shown or else the first that has an error. */
  async follow(state, layers) {
    const layer = [differing(state, layers), layers[state.a], ...layers].find((candidate) => candidate && (candidate.reference || isMap(candidate)));
    const listed = state.worst ? JSON.stringify([layer?.url, layer?.reference?.url, layer?.label, layer && coloured(state, layer).request.look]) : '';
    if (listed === this.#listed) return;
    this.#listed = listed;
    if (!state.worst) return replace(this.element);
    if (!layer) return replace(this.element, h('p.quiet', {}, 'None of these layers has an error: there is no reference.'));
    let places;
    let picture;
    try {
      places = await ask('worst', {layer: {...source(layer), reference: layer.reference && source(layer.reference)}});
      const {operation, request} = coloured(state, layer);
      picture = await bitmap(operation, request);
    } catch (error) {
      if (listed === this.#listed) replace(this.element, h('p.problem', {}, error.message));
      return;
    }
    if (listed !== this.#listed) return;  // something else is shown meanwhile
    replace(this.element, h('div.section-head', {}, h('h3', {}, `Worst places of ${layer.label}`),
      h('button.plain', {type: 'button', onclick: this.#close}, 'Close the list')),
    places.length === 0 ? h('p.quiet', {}, 'There are none: it is 0 everywhere.') : [h('p.quiet.note', {}, 'Squares of 16×16 pixels, largest sums first; the number and the place are those of the largest pixel in each.'), h('ol.worst', {}, places.map((place, i) => this.#item(place, i, picture.bitmap)))]);
  }

  #item({x, y, value}, i, picture) {
    const canvas = h('canvas', {width: shown, height: shown, 'aria-hidden': true});
    const context = canvas.getContext('2d');
    context.imageSmoothingEnabled = false;
    context.drawImage(picture, x - cut / 2, y - cut / 2, cut, cut, 0, 0, shown, shown);
    return h('li', {}, h('button.place', {type: 'button', 'aria-label': `Place ${i + 1}: x ${x}, y ${y}, ${valueText(value, 'half')}`, onclick: () => {
      this.#goTo(x, y);
      announce(`x ${x}, y ${y}`);
    }}, canvas, h('span', {}, valueText(value, 'half'))));
  }
}
