// The frame that is shown: a slider over a run's frames, and their playback.
import {h, setText} from './dom.js';

const framesPerSecond = 8;

export class Playback {
  slider = h('input', {type: 'range', step: 1, oninput: () => this.#choose(this.slider.valueAsNumber)});
  number = h('output.frame-number', {});
  button = h('button', {type: 'button', 'aria-pressed': 'false', onclick: () => this.toggle()}, 'Play');
  #first;
  #last;
  #choose;
  #settled;
  #turn = 0;  // of the playback that goes on; 0: none

  /** `choose(frame)` shows a frame; `settled()` resolves when it is on the screen. */
  constructor([first, last], choose, settled) {
    [this.#first, this.#last, this.#choose, this.#settled] = [first, last, choose, settled];
    this.slider.setAttribute('min', first);
    this.slider.setAttribute('max', last);
  }

  get playing() {
    return this.#turn > 0;
  }

  show(frame) {
    if (this.slider.valueAsNumber !== frame) this.slider.value = frame;
    setText(this.number, `${frame}`);
  }

  async toggle() {
    const mine = this.playing ? 0 : Date.now();
    this.#turn = mine;
    this.button.setAttribute('aria-pressed', String(this.playing));
    this.button.textContent = mine ? 'Stop' : 'Play';
    while (mine && this.#turn === mine) {
      const due = performance.now() + 1000 / framesPerSecond;
      const frame = this.slider.valueAsNumber;
      this.#choose(frame < this.#last ? frame + 1 : this.#first);
      await new Promise(requestAnimationFrame);
      await this.#settled();
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
    }
  }

  close() {
    this.#turn = 0;
  }
}
