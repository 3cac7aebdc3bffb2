// Pointer, fingers, wheel and keys of a comparison.
import {toneNames} from './pixel_math.js';
import {channels, measures, modes, zoomSteps} from './view_state.js';

const grab = 14;        // how near to the line, in CSS pixels, a pointer takes hold of it
const steady = 3;       // what a pointer may move for a click
const arrows = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]};

const middle = ([p, q]) => ({x: (p.x + q.x) / 2, y: (p.y + q.y) / 2});
const distance = ([p, q]) => Math.hypot(p.x - q.x, p.y - q.y);

function pointIn(element, event) {
  const box = element.getBoundingClientRect();
  return {x: event.clientX - box.left, y: event.clientY - box.top};
}

// Two fingers move the picture with them and zoom by how their distance changes; one drags the line, a box or the picture.
class Dragging {
  #view;
  #canvas;
  #pointers = new Map();  // id -> point, of all that are down
  #drag = null;           // of the first: {what, x, y, start, from, moved}

  constructor(view, canvas) {
    this.#view = view;
    this.#canvas = canvas;
    canvas.addEventListener('pointerdown', (event) => this.#down(event));
    canvas.addEventListener('pointermove', (event) => this.#move(event));
    canvas.addEventListener('pointerup', (event) => this.#up(event));
    canvas.addEventListener('pointercancel', (event) => {
      this.#pointers.delete(event.pointerId);
      this.#drag = null;
    });
  }

  #nearLine({x}) {
    const {wiped, line} = this.#view.geometry;
    return wiped && Math.abs(x - line) < grab;
  }

  #down(event) {
    const point = pointIn(this.#canvas, event);
    this.#pointers.set(event.pointerId, point);
    this.#canvas.setPointerCapture(event.pointerId);
    const what = event.shiftKey ? 'box' : this.#nearLine(point) ? 'wipe' : 'pan';
    this.#drag = this.#pointers.size > 1 ? null : {what, ...point, start: this.#view.geometry.under(point), from: point};
  }

  #move(event) {
    const point = pointIn(this.#canvas, event);
    this.#view.point(point);
    const before = [...this.#pointers.values()];
    if (this.#pointers.has(event.pointerId)) this.#pointers.set(event.pointerId, point);
    if (before.length === 2) return this.#pinch(before, [...this.#pointers.values()]);
    const drag = this.#drag;
    if (!drag) return this.#canvas.classList.toggle('at-line', this.#nearLine(point));
    if (drag.what === 'wipe') this.#view.setShare(point.x / this.#view.geometry.canvas.width);
    else if (drag.what === 'box') this.#view.dragBox(drag.start, this.#view.geometry.under(point));
    else if (Math.hypot(point.x - drag.from.x, point.y - drag.from.y) > steady) {
      drag.moved = true;
      this.#view.pan(point.x - drag.x, point.y - drag.y);
      Object.assign(drag, point);
    }
  }

  #pinch(before, after) {
    const [from, to] = [middle(before), middle(after)];
    const under = this.#view.geometry.under(from);
    if (!under || distance(before) === 0) return;
    const {cell} = under;
    this.#view.zoomTo(this.#view.geometry.placement(cell).scale * distance(after) / distance(before), cell, {x: from.x - cell.x, y: from.y - cell.y});
    this.#view.pan(to.x - from.x, to.y - from.y);
  }

  #up(event) {
    this.#pointers.delete(event.pointerId);
    const drag = this.#drag;
    this.#drag = null;
    if (drag?.what === 'box') this.#view.boxChanged();
    else if (drag?.what === 'pan' && !drag.moved && drag.start?.inside) this.#view.choosePixel(drag.start);
  }
}

function listenToMinimap(view, minimap) {
  let on = false;
  const jump = (event) => {
    const {width, height} = minimap.getBoundingClientRect();
    const {x, y} = pointIn(minimap, event);
    const {size} = view.geometry;
    view.goTo((x / width) * size.width, (y / height) * size.height, view.geometry.placement().scale);
  };
  minimap.addEventListener('pointerdown', (event) => {
    on = true;
    minimap.setPointerCapture(event.pointerId);
    jump(event);
  });
  minimap.addEventListener('pointermove', (event) => on && jump(event));
  minimap.addEventListener('pointerup', () => (on = false));
}

export function listenToView(view, canvas, minimap) {
  new Dragging(view, canvas);
  listenToMinimap(view, minimap);
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const point = pointIn(canvas, event);
    const under = view.geometry.under(point);
    if (!under) return;
    const {cell} = under;
    view.zoomTo(view.geometry.placement(cell).scale * 1.25 ** -Math.sign(event.deltaY), cell, {x: point.x - cell.x, y: point.y - cell.y});
  }, {passive: false});
  canvas.addEventListener('keydown', (event) => {
    if (event.key === 'Enter') {
      event.preventDefault();
      view.chooseHere();
    }
    const arrow = arrows[event.key];
    if (!arrow || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const [dx, dy] = arrow;
    if (event.shiftKey && view.state.box) view.moveBox(-dx, -dy);
    else view.pan(dx * 40, dy * 40);
  });
}

/** The view's keys, for keys.js. */
export function viewKeys(view) {
  const s = () => view.state;
  const change = (entries) => () => view.change(entries());
  const next = (list, value) => list[(list.indexOf(value) + 1) % list.length];
  return [
    ...Object.entries(modes).map(([mode, [title, key]]) => ({keys: [key], text: title, act: change(() => ({mode}))})),
    {keys: ['1', '2', '3', '4', '5', '6'], text: 'flip to that layer', act: (key) => Number(key) <= view.layers.length && view.change({mode: 'flip', a: Number(key) - 1})},
    {keys: ['b'], text: 'swap the two layers', act: change(() => ({a: s().b, b: s().a}))},
    {keys: [','], text: 'line to the left', act: () => view.setShare(s().share - 0.02)},
    {keys: ['.'], text: 'line to the right', act: () => view.setShare(s().share + 0.02)},
    {keys: ['0'], text: 'whole image', act: () => view.zoomTo(0)},
    {keys: ['+', '='], text: 'zoom in', act: () => view.zoomBy(1.5)},
    {keys: ['-'], text: 'zoom out', act: () => view.zoomBy(1 / 1.5)},
    {keys: ['z'], text: 'next zoom of 1, 2, 4, … 64', act: () => view.geometry.size && view.zoomTo(zoomSteps.find((step) => step > view.geometry.placement().scale * 1.01) ?? 1)},
    {keys: ['e'], text: 'brighter by half a stop', act: change(() => ({exposure: Math.min(8, s().exposure + 0.5)}))},
    {keys: ['E'], text: 'darker by half a stop', act: change(() => ({exposure: Math.max(-8, s().exposure - 0.5)}))},
    {keys: ['t'], text: 'next tone curve', act: change(() => ({tone: next(toneNames, s().tone)}))},
    {keys: ['c'], text: 'next channel', act: change(() => ({channel: next(Object.keys(channels), s().channel)}))},
    {keys: ['o'], text: 'false colour', act: change(() => ({falseColour: !s().falseColour}))},
    {keys: ['l'], text: 'logarithmic colours', act: change(() => ({log: !s().log}))},
    {keys: ['g'], text: 'difference: twice the gain', act: change(() => ({gain: Math.min(64, s().gain * 2)}))},
    {keys: ['G'], text: 'difference: half the gain', act: change(() => ({gain: Math.max(1, s().gain / 2)}))},
    {keys: ['n'], text: 'difference: with its sign', act: change(() => ({signed: !s().signed}))},
    {keys: ['q'], text: 'difference: next measure', act: change(() => ({measure: next(Object.keys(measures), s().measure)}))},
    {keys: ['m'], text: 'magnifier', act: () => view.toggleMagnifier()},
    {keys: ['x'], text: 'a box in the middle of what is seen, or none', act: () => view.boxHere()},
    {keys: ['v'], text: 'list of the worst places', act: () => view.toggleWorst()},
  ];
}

/** What else there is to know of the view's keys and pointer. */
export const viewHints = [
  {keys: ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], text: 'on the picture: move it; with Shift: move the box', act: () => {}},
  {keys: ['Enter'], text: 'on the picture: the story of the pixel under the pointer, or of the one in the middle', act: () => {}},
  {keys: ['click'], text: "the pixel's story", act: () => {}},
  {keys: ['drag'], text: 'move the picture or the line; with Shift: draw a box', act: () => {}},
  {keys: ['wheel'], text: 'zoom', act: () => {}},
  {keys: ['fingers'], text: 'two zoom and move the picture', act: () => {}},
];
