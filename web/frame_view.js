// A frame of a capture: its draws as a tree, by material, beside its picture. A draw that is chosen is highlighted in the picture,
// and a click in the picture chooses the draw that is seen there.
import {getInTurn} from './api.js';
import {announce, h, replace, setAttribute} from './dom.js';
import {bytes, count} from './format.js';

const mostDraws = 3000;  // elements of the tree; what is beyond is counted

/** A frame as the service draws it at `size`; null when it is not `wanted()` any more. */
export const frameOf = (hash, frame, [width, height], wanted) => getInTurn(`/api/captures/${hash}/frame?frame=${frame}&width=${width}&height=${height}`, wanted);

/** The picture of a view that the service made, decoded. */
export async function pictureOf(view) {
  const image = new Image();
  image.src = `data:image/png;base64,${view.picture}`;
  await image.decode();
  return image;
}

/** The draw that each pixel shows, -1 the sky, from runs of them. */
export function drawsOf({seen, size: [width, height]}) {
  const draws = new Int32Array(width * height);
  for (let i = 0, at = 0; i < seen.length; at += seen[i + 1], i += 2) draws.fill(seen[i], at, at + seen[i + 1]);
  return draws;
}

/** Draws by material, in the order of each one's first: [{material, draws}]. */
export function byMaterial(draws) {
  const groups = new Map();
  for (const draw of draws) {
    const {number} = draw.material;
    if (!groups.has(number)) groups.set(number, {material: draw.material, draws: []});
    groups.get(number).draws.push(draw);
  }
  return [...groups.values()];
}

const sum = (draws, key) => draws.reduce((total, draw) => total + draw[key], 0);
const nameOf = ({draw, name}) => `${draw} ${name || 'without a name'}`;

export class FrameView {
  element = h('section.frame-view', {'aria-label': 'Draws of a frame'});
  #hash;
  #size;
  #view = null;
  #picture = null;
  #draws = null;      // of each pixel
  #groups = [];       // by material
  #chosen = null;     // numbers of draws
  #told;
  #turn = 0;
  #canvas = h('canvas.frame-canvas', {tabindex: 0, role: 'img'});
  #tree = h('div.draw-tree', {});
  #details = h('div.draw-details', {'aria-live': 'polite'});

  /** Of the capture with this hash; pictures are `size` [width, height]. `told({draw, material})` hears what is chosen, null what is not. */
  constructor(hash, size, told = () => {}) {
    this.#hash = hash;
    this.#size = size;
    this.#told = told;
    this.#canvas.addEventListener('click', (event) => {
      const box = this.#canvas.getBoundingClientRect();
      const [width, height] = this.#view.size;
      const x = Math.min(width - 1, Math.floor(((event.clientX - box.left) / box.width) * width));
      const y = Math.min(height - 1, Math.floor(((event.clientY - box.top) / box.height) * height));
      const draw = this.#draws[y * width + x];
      this.#choose(draw < 0 ? null : [draw]);
    });
    this.#canvas.addEventListener('keydown', (event) => event.key === 'Escape' && this.#choose(null));
  }

  /** Asks for a frame and shows it with a draw or all draws of a material chosen, when it has them. */
  async show(frame, choice = {}) {
    const mine = ++this.#turn;
    this.#chosen = null;
    replace(this.element, h('p.quiet', {role: 'status'}, `Frame ${frame} is being drawn …`), h('div.skeleton', {}));
    try {
      const view = await frameOf(this.#hash, frame, this.#size, () => mine === this.#turn);
      if (!view) return;
      const picture = await pictureOf(view);
      if (mine !== this.#turn) return;
      [this.#view, this.#picture, this.#draws] = [view, picture, drawsOf(view)];
    } catch (error) {
      if (mine === this.#turn) replace(this.element, h('p.problem', {role: 'alert'}, error.message));
      return;
    }
    this.#build(choice);
    announce(`Frame ${frame} is shown`);
  }

  /** Chooses the draw after the chosen one, or before it, in submission order, of those that are seen; 0: none. */
  step(by) {
    if (!this.#view) return;
    if (by === 0) return this.#choose(null);
    const seen = this.#view.draws.filter(({pixels}) => pixels > 0).map(({draw}) => draw);
    if (seen.length === 0) return;
    const now = this.#chosen ? [...this.#chosen] : [];
    const at = by > 0 ? seen.findIndex((draw) => draw > Math.max(-1, ...now)) : seen.findLastIndex((draw) => draw < (now.length > 0 ? Math.min(...now) : Infinity));
    this.#choose([seen[at >= 0 ? at : by > 0 ? 0 : seen.length - 1]]);
  }

  #build({draw, material}) {
    const {draws, frame, size: [width, height]} = this.#view;
    Object.assign(this.#canvas, {width, height});
    replace(this.element, h('div.frame-parts', {}, h('div.frame-picture', {}, this.#canvas, this.#details),
      h('div', {}, h('p.quiet', {}, `Frame ${frame}: ${count(draws.length)} draws, ${count(sum(draws, 'triangles'))} triangles`), this.#tree)));
    this.#groups = byMaterial(draws.slice(0, mostDraws));
    replace(this.#tree, this.#groups.map((group) => this.#branch(group)),
      draws.length > mostDraws && h('p.quiet', {}, `and ${count(draws.length - mostDraws)} draws more, which a click in the picture finds`));
    const whole = this.#groups.find((group) => group.material.number === material)?.draws.map((one) => one.draw);
    this.#choose(draws[draw] ? [draw] : whole ?? null);
  }

  // A material with its draws; more than a few are shown when it is opened.
  #branch({material, draws}) {
    const title = `${material.name || `material ${material.number}`}`;
    const all = draws.map(({draw}) => draw);
    const list = h('ul', {});
    const fill = () => list.hasChildNodes() || replace(list, draws.map((draw) => h('li', {}, this.#button(nameOf(draw), [draw.draw],
      `${count(draw.triangles)} triangles, ${count(draw.pixels)} pixels`))));
    const details = h('details', {ontoggle: () => details.open && fill()}, h('summary', {}, title, h('span.quiet', {}, ` ${count(draws.length)} draws, ${count(sum(draws, 'triangles'))} triangles`)),
      draws.length > 1 && this.#button('all of it', all, `${count(sum(draws, 'pixels'))} pixels`), list);
    details.dataset.material = material.number;
    return details;
  }

  #button(title, draws, text) {
    return h('button.draw', {type: 'button', 'aria-pressed': 'false', 'data-draws': draws.join(','), onclick: () => this.#choose(draws)}, title, h('span.quiet', {}, ` ${text}`));
  }

  // Chooses draws by their numbers, null none.
  #choose(draws) {
    this.#chosen = draws && new Set(draws);
    const first = draws && this.#view.draws[draws[0]];
    const only = draws?.length === 1 ? first : null;
    if (first) {
      const branch = this.#tree.querySelector(`details[data-material="${first.material.number}"]`);
      if (branch && !branch.open) branch.open = true;
      branch?.dispatchEvent(new Event('toggle'));
    }
    const key = draws?.join(',');
    for (const button of this.#tree.querySelectorAll('.draw')) {
      setAttribute(button, 'aria-pressed', String(button.dataset.draws === key));
      if (button.dataset.draws === key) button.scrollIntoView({block: 'nearest'});
    }
    this.#paint();
    this.#tell(draws, only);
    this.#told({draw: only?.draw ?? null, material: first && !only ? first.material.number : null});
  }

  // The picture, dimmed where another draw is seen than the chosen ones.
  #paint() {
    const {size: [width, height], draws, frame} = this.#view;
    const context = this.#canvas.getContext('2d', {willReadFrequently: true});
    context.drawImage(this.#picture, 0, 0);
    const chosen = this.#chosen;
    setAttribute(this.#canvas, 'aria-label', `Frame ${frame}${chosen ? `, highlighted: ${[...chosen].slice(0, 3).map((draw) => nameOf(draws[draw])).join(', ')}` : ''}`);
    if (!chosen) return;
    const image = context.getImageData(0, 0, width, height);
    for (let i = 0; i < this.#draws.length; ++i) {
      if (chosen.has(this.#draws[i])) continue;
      const grey = 0.2126 * image.data[4 * i] + 0.7152 * image.data[4 * i + 1] + 0.0722 * image.data[4 * i + 2];
      for (let c = 0; c < 3; ++c) image.data[4 * i + c] = 0.25 * grey;
    }
    context.putImageData(image, 0, 0);
  }

  #tell(draws, only) {
    if (!draws) return replace(this.#details, h('p.quiet', {}, 'Click in the picture for the draw that is seen there, or choose one in the tree.'));
    if (!only) return replace(this.#details, h('p', {}, `${count(draws.length)} draws are highlighted.`));
    const facts = [['draw', nameOf(only)], ['triangles', `${count(only.triangles)}${only.instances > 1 ? ` in ${count(only.instances)} instances` : ''}`],
      ['mesh', `${count(only.vertices)} vertices, indices ${only.index_type}, reads ${bytes(only.bytes)}`], ['material', `${only.material.number} ${only.material.name}`],
      ['textures', only.textures.map(({slot, texture, name}) => `${slot.replace(/_texture$/, '').replaceAll('_', ' ')}: ${texture} ${name}`).join('; ') || 'none'], ['seen in', `${count(only.pixels)} pixels`]];
    replace(this.#details, h('dl.facts.wide', {}, facts.map(([name, text]) => h('div', {}, h('dt', {}, name), h('dd', {}, text)))));
  }
}
