// Parts of a page that follow its picture: each is drawn in a task of its own, so that none holds up the next frame or a key.
const quiet = 200;  // ms without another wish after which what is out of sight is drawn too

const due = [];
let timer = 0;

// One part a task; the browser draws and takes input between them.
function work() {
  timer = 0;
  due.shift()?.now();
  if (due.length > 0) timer = setTimeout(work, 0);
}

/**
 * A part of the page: `draw()` is called soon after ask() while `element` is in sight, else once nothing was asked for a while.
 * Until then the element is busy (aria-busy).
 */
export class Later {
  #element;
  #draw;
  #wanted = false;
  #seen = false;
  #timer = 0;
  #observer = new IntersectionObserver((entries) => {
    this.#seen = entries.at(-1).isIntersecting;
    if (this.#seen && this.#wanted) this.#enqueue();
  }, {rootMargin: '150px'});

  constructor(element, draw) {
    this.#element = element;
    this.#draw = draw;
    this.#observer.observe(element);
  }

  ask() {
    this.#wanted = true;
    this.#element.setAttribute('aria-busy', 'true');
    clearTimeout(this.#timer);
    if (this.#seen) this.#enqueue();
    else this.#timer = setTimeout(() => this.#enqueue(), quiet);
  }

  /** Draws what was asked for, at once. */
  now() {
    clearTimeout(this.#timer);
    if (!this.#wanted) return;
    this.#wanted = false;
    this.#draw();
    this.#element.removeAttribute('aria-busy');
  }

  close() {
    this.#observer.disconnect();
    clearTimeout(this.#timer);
    this.#wanted = false;
  }

  #enqueue() {
    if (!due.includes(this)) due.push(this);
    timer ||= setTimeout(work, 0);
  }
}
