// The frames of a capture as a film strip: small pictures of up to 24 of them. A frame that is clicked is shown.
import {h, replace} from './dom.js';
import {frameOf, pictureOf} from './frame_view.js';

const most = 24;
const size = [128, 72];

/** Up to `most` frames of `number`, evenly apart, the first and the last among them. */
export function chosenFrames(number) {
  const shown = Math.min(number, most);
  return Array.from({length: shown}, (_, i) => (shown === 1 ? 0 : Math.round((i * (number - 1)) / (shown - 1))));
}

export class FilmStrip {
  element = h('ol.film-strip', {'aria-label': 'Frames'});
  #hash;
  #frames;
  #closed = false;
  #buttons;

  /** `choose(frame)` is called for a frame that is clicked. */
  constructor(hash, number, choose) {
    this.#hash = hash;
    this.#frames = chosenFrames(number);
    this.#buttons = this.#frames.map((frame) => h('button.film-frame', {type: 'button', 'aria-pressed': 'false', 'aria-label': `Frame ${frame}`, onclick: () => choose(frame)},
      h('span.film-picture', {}), h('span', {}, frame)));
    replace(this.element, this.#buttons.map((button) => h('li', {}, button)));
  }

  select(frame) {
    this.#buttons.forEach((button, i) => button.setAttribute('aria-pressed', String(this.#frames[i] === frame)));
  }

  /** Fills in the pictures, until it is closed. */
  async fill() {
    for (let i = 0; i < this.#frames.length && !this.#closed; ++i) {
      const place = this.#buttons[i].firstElementChild;
      try {
        const view = await frameOf(this.#hash, this.#frames[i], size, () => !this.#closed);
        if (!view) return;
        const image = await pictureOf(view);
        image.alt = '';
        replace(place, image);
      } catch (error) {
        place.textContent = 'no picture';
        place.title = error.message;
      }
    }
  }

  close() {
    this.#closed = true;
  }
}
