// One pixel's story, told by the service: the samples on their pattern, the fragments that came, what the technique did with
// each, what it kept and lit, and the same of msaa and the reference beside it.
import {get} from './api.js';
import {announce, h, replace} from './dom.js';
import {fixed, significant} from './format.js';

const svg = 'http://www.w3.org/2000/svg';
// Okabe and Ito's palette, as the bars of passes have it.
const colours = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#b8a800', '#7a7a7a'];
const colourOf = (fragment) => (fragment === null ? 'transparent' : colours[fragment % colours.length]);

export class PixelStory {
  #turn = 0;
  #closed;
  element = h('section.pixel-story', {hidden: true, 'aria-label': "A pixel's story"});

  /** `closed()` is called when it is closed. */
  constructor(closed) {
    this.#closed = closed;
  }

  /** Asks for the story of `pixel` {x, y} of a run's frame and shows it. */
  async show(run, technique, parameters, frame, pixel) {
    const mine = ++this.#turn;
    this.element.hidden = false;
    const heading = () => h('div.section-head', {}, h('h2', {}, `Pixel ${pixel.x}, ${pixel.y} of frame ${frame}`), h('span.spacer', {}),
      h('button', {type: 'button', onclick: () => this.#close()}, 'Close'));
    replace(this.element, heading(), h('p.quiet', {}, 'Being told: the frame is replayed for it …'));
    const query = new URLSearchParams({technique: [technique, ...Object.entries(parameters).map(([name, value]) => `${name}=${value}`)].join(':'),
      frame, x: pixel.x, y: pixel.y, samples: run.request.samples});
    const size = run.head ?? run.request;
    if (size.width && size.height) {
      query.set('width', size.width);
      query.set('height', size.height);
    }
    if (run.request.reference_samples === 0) query.set('reference_samples', 0);
    let story;
    try {
      story = await get(`/api/captures/${run.capture.hash}/pixel?${query}`);
    } catch (error) {
      if (mine === this.#turn) replace(this.element, heading(), h('p.problem', {role: 'alert'}, error.message));
      return;
    }
    if (mine !== this.#turn) return;  // another pixel was chosen meanwhile
    replace(this.element, heading(), story.stories.map(techniqueStory), story.reference && referenceStory(story.reference));
    announce(`The story of pixel ${pixel.x}, ${pixel.y} is there`);
  }

  #close() {
    ++this.#turn;
    this.element.hidden = true;
    this.#closed();
  }
}

const vector = (values, digits = 3) => values.map((value) => fixed(value, digits)).join(' ');

function swatch(display) {
  const element = h('span.swatch', {});
  element.style.background = `rgb(${display.map((value) => Math.round(255 * value)).join(' ')})`;
  return element;
}

function fragmentKey(number) {
  const key = h('span.key', {});
  key.style.background = colourOf(number);
  return [key, `${number}`];
}

function triangleText({draw, instance, triangle, material, material_name: name, back_face: back}) {
  return `draw ${draw}, instance ${instance}, triangle ${triangle}, material ${material}${name ? ` (${name})` : ''}${back ? ', back face' : ''}`;
}

// The pixel as a square with its samples in the colours of the fragments that they show.
function patternPicture(pattern) {
  const picture = document.createElementNS(svg, 'svg');
  picture.setAttribute('viewBox', '-0.56 -0.56 1.12 1.12');
  picture.setAttribute('class', 'pattern');
  picture.setAttribute('role', 'img');
  picture.setAttribute('aria-label', `${pattern.length} samples`);
  const add = (name, attributes, text) => {
    const element = document.createElementNS(svg, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text) element.append(Object.assign(document.createElementNS(svg, 'title'), {textContent: text}));
    picture.append(element);
  };
  add('rect', {x: -0.5, y: -0.5, width: 1, height: 1, class: 'pixel'});
  const radius = pattern.length > 16 ? 0.03 : 0.05;
  pattern.forEach(({at: [x, y], fragment, depth}, sample) => {
    add('circle', {cx: x, cy: y, r: radius, fill: colourOf(fragment), class: 'place'},
      `sample ${sample}: ${fragment === null ? 'sky' : `fragment ${fragment}, depth ${significant(depth, 6)}`}`);
  });
  return picture;
}

function table(caption, heads, rows) {
  return h('div.scroll', {}, h('table', {}, h('caption', {}, caption), h('thead', {}, h('tr', {}, heads.map((head) => h('th', {scope: 'col'}, head)))),
    h('tbody', {}, rows.map((cells) => h('tr', {}, cells.map((cell) => h('td', {}, cell)))))));
}

function techniqueStory(story) {
  const parameters = Object.entries(story.parameters).map(([name, value]) => `${name}=${value}`).join(' ');
  const fragments = story.fragments.filter(({covers}) => covers !== '0x0');
  return h('article.story', {},
    h('h3', {}, story.technique, h('span.quiet', {}, ` ${parameters}`)),
    h('p', {}, swatch(story.result.display), `radiance ${vector(story.result.radiance, 4)}, ${story.result.executions} lighting executions`),
    h('div.story-body', {}, patternPicture(story.pattern),
      table('Fragments, in submission order', ['#', 'triangle', 'covers', 'passes', 'depth', 'normal', 'albedo'], fragments.map((fragment) => [
        fragmentKey(fragment.number), triangleText(fragment.triangle),
        fragment.alpha_leaves ? `${fragment.covers}, alpha leaves ${fragment.alpha_leaves}` : fragment.covers, fragment.passes,
        significant(fragment.plane.depth, 6), vector(fragment.surface.normal, 2), vector(fragment.surface.albedo, 2)]))),
    story.steps && table('What was done with each', ['#', 'what'], story.steps.map(({fragment, what}) => [fragmentKey(fragment), what])),
    story.surfaces && keptTable(story.surfaces),
    story.executions && table('Lighting', ['of', 'samples', 'weight', 'value'],
      story.executions.map((one) => [one.of, one.samples, one.weight, vector(one.value, 4)])),
    story.resolve && h('p', {}, `Resolve: ${story.resolve.what}`),
    story.filter && h('div.story-body', {}, lumaPicture(story.filter), table('The filter', ['step', 'what'], story.filter.map(({kind, what}) => [kind, what]))));
}

// Surfaces, blocks, or aggregates, whose colours are split.
function keptTable(surfaces) {
  const weighed = surfaces.some(({weight}) => weight !== undefined);
  const split = surfaces.some(({surface}) => surface.diffuse);
  return table('Kept', ['slot', 'covers', ...(weighed ? ['weight'] : []), 'depth', 'normal', ...(split ? ['diffuse', 'reflectance'] : ['albedo']), 'roughness'],
    surfaces.map(({slot, covers, weight, nearest, farthest, surface}) => [slot, covers, ...(weighed ? [weight] : []),
      `${significant(nearest, 5)} to ${significant(farthest, 5)}`, vector(surface.normal, 2),
      ...(split ? [vector(surface.diffuse, 2), vector(surface.reflectance, 2)] : [vector(surface.albedo, 2)]), fixed(surface.roughness, 2)]));
}

// The 3x3 pixels whose luma a filter looks at, as greys with their values.
function lumaPicture(steps) {
  const neighbourhood = steps.find((step) => step.neighbourhood)?.neighbourhood;
  if (!neighbourhood) return null;
  return h('div.luma', {role: 'img', 'aria-label': `Luma of 3 by 3 pixels: ${neighbourhood.map((value) => fixed(value, 3)).join(', ')}`},
    neighbourhood.map((value) => {
      const cell = h('span', {}, fixed(value, 2));
      const grey = Math.round(255 * Math.min(Math.max(value, 0), 1));
      cell.style.background = `rgb(${grey} ${grey} ${grey})`;
      cell.style.color = grey > 127 ? '#000' : '#fff';
      return cell;
    }));
}

// Shadings by triangle.
function referenceStory(reference) {
  const parts = new Map();
  for (const {triangle, samples, radiance} of reference.shadings) {
    const name = triangleText(triangle);
    const part = parts.get(name) ?? {samples: 0, shadings: 0, sum: [0, 0, 0]};
    part.samples += samples;
    part.shadings += 1;
    part.sum = part.sum.map((value, c) => value + samples * radiance[c]);
    parts.set(name, part);
  }
  return h('article.story', {},
    h('h3', {}, 'reference', h('span.quiet', {}, ` ${reference.samples} samples`)),
    h('p', {}, swatch(reference.result.display), `radiance ${vector(reference.result.radiance, 4)}`),
    table('Shading samples by triangle', ['triangle', 'samples', 'shadings', 'mean'], [...parts].map(([name, part]) => [
      name, part.samples, part.shadings, vector(part.sum.map((value) => value / part.samples), 4)])));
}
