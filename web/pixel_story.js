// One pixel's story, told by the service: the samples on their pattern, the fragments that came, what the technique did with
// each, what it kept and lit, and the same of msaa and the reference beside it.
import {getInTurn} from './api.js';
import {announce, h, replace} from './dom.js';
import {download} from './files.js';
import {fixed, significant} from './format.js';
import {dull, foldedRows, fragmentColours, fragmentKey, later, linearColour, maskPicture, numbersText, patternPicture, samplesOf, shadingsPicture, swatch, table, triangleText, vector} from './story_parts.js';

const steps = [['←', 'to the left', -1, 0], ['↑', 'above', 0, -1], ['↓', 'below', 0, 1], ['→', 'to the right', 1, 0]];

export class PixelStory {
  element = h('section.pixel-story', {hidden: true, 'aria-label': "A pixel's story"});
  #turn = 0;
  #chosen;

  /** `chosen(pixel)` hears which pixel of the story's frame was chosen from here, null when it was closed. */
  constructor(chosen) {
    this.#chosen = chosen;
  }

  /**
   * Asks for the story of `pixel` {x, y} and shows it. `of`: {hash of the capture, technique, parameters, samples, frame, width,
   * height, reference_samples, point_lights}; what is undefined is left to the service.
   */
  async show(of, pixel) {
    const mine = ++this.#turn;
    const told = () => mine === this.#turn;
    this.element.hidden = false;
    const moved = this.element.querySelector('.story-steps')?.contains(document.activeElement) ? document.activeElement.dataset.step : null;
    const heading = this.#heading(of, pixel);
    if (this.element.querySelector('.story')) {  // the one before stays until this one is there
      this.element.firstElementChild.replaceWith(heading);
      this.element.setAttribute('aria-busy', 'true');
    } else {
      replace(this.element, heading, h('p.quiet', {role: 'status'}, 'Being told: the frame is replayed for it …'), h('div.skeleton', {}));
    }
    if (moved) heading.querySelector(`[data-step="${moved}"]`).focus({preventScroll: true});
    try {
      const story = await this.#ask(of, pixel, told);
      if (!story || !told()) return;  // another pixel was chosen meanwhile
      const focused = heading.contains(document.activeElement) ? document.activeElement : null;
      replace(this.element, heading, glance(story), story.stories.map((one, i) => techniqueStory(one, i > 0 ? story.stories[0] : null)), story.reference && referenceStory(story.reference));
      focused?.focus({preventScroll: true});
      heading.querySelector('.story-json').disabled = false;
      heading.querySelector('.story-json').onclick = () => download(`pixel-${pixel.x}-${pixel.y}-frame-${of.frame}.json`, 'application/json', `${JSON.stringify(story, null, 1)}\n`);
      announce(`The story of pixel ${pixel.x}, ${pixel.y} is there`);
    } catch (error) {
      if (told()) replace(this.element, heading, h('p.problem', {role: 'alert'}, error.status === 404 ? 'The service has no capture of this content, so the frame can\'t be replayed: upload it, and choose the pixel again.' : error.message));
    }
    if (told()) this.element.removeAttribute('aria-busy');
  }

  #ask({hash, technique, parameters, ...rest}, {x, y}, wanted) {
    const text = [technique, ...Object.entries(parameters).map(([name, value]) => `${name}=${value}`)].join(':');
    const query = new URLSearchParams({technique: text, x, y});
    for (const [name, value] of Object.entries(rest)) if (value !== undefined && value !== null) query.set(name, value);
    return getInTurn(`/api/captures/${hash}/pixel?${query}`, wanted);
  }

  #heading({frame, width, height}, {x, y}) {
    const step = ([arrow, where, dx, dy]) => h('button.plain', {type: 'button', 'aria-label': `The pixel ${where}`, 'data-step': where, title: `The pixel ${where}`,
      disabled: x + dx < 0 || y + dy < 0 || x + dx >= (width || Infinity) || y + dy >= (height || Infinity), onclick: () => this.#chosen({x: x + dx, y: y + dy})}, arrow);
    return h('div.section-head', {}, h('h2', {}, `Pixel ${x}, ${y} of frame ${frame}`), h('span.story-steps', {role: 'group', 'aria-label': 'Neighbouring pixels'}, steps.map(step)), h('span.spacer', {}),
      h('button.story-json', {type: 'button', disabled: true}, 'JSON of the story'), h('button', {type: 'button', onclick: () => this.close()}, 'Close'));
  }

  close() {
    ++this.#turn;
    this.element.hidden = true;
    replace(this.element);
    this.#chosen(null);
  }
}

const parameterText = ([name, value]) => `${name}=${typeof value === 'number' ? Number(significant(value, 4)) : value}`;

// What came out, of all of them beside each other.
function glance({stories, reference}) {
  const of = (name, result, kept) => [h('strong', {}, name), [swatch(result.display), vector(result.display)], vector(result.radiance, 4), result.executions ?? '–', kept];
  return h('div.glance', {}, table('What came out', ['technique', 'display', 'radiance', 'lighting executions', 'from'],
    [...stories.map((story) => of(story.technique, story.result, story.resolve.what.replace(/^the mean of /, 'mean of '))), ...(reference ? [of('reference', reference.result, `mean of ${reference.samples} samples`)] : [])]));
}

function techniqueStory(story, before) {
  const colourOf = fragmentColours(story);
  const mask = (text, fragment) => maskPicture(text, story.pattern, fragment === undefined ? undefined : colourOf(fragment));
  const same = before && JSON.stringify(before.fragments) === JSON.stringify(story.fragments);
  return h('article.story', {},
    h('h3', {}, story.technique, h('span.quiet', {}, ` ${Object.entries(story.parameters).map(parameterText).join(' ')}`)),
    h('div.story-body', {}, patternPicture(story.pattern, colourOf), samplesTable(story, colourOf)),
    same ? h('p.quiet', {}, `The same fragments came as to ${before.technique}.`) : fragmentsTable(story, colourOf, mask),
    story.steps && table('What was done with each', ['#', 'what'], foldedRows(story.steps, ({kind}) => dull.has(kind), ({fragment, what}) => [fragmentKey(fragment, colourOf), h('div.words', {}, stepText(what))],
      (rows) => `${rows.length} fragments (${numbersText(rows.map(({fragment}) => fragment))}) ${[...new Set(rows.map(({what}) => what))].join('; ')}`)),
    story.definition && later('How aggregates were found', () => definitionTable(story)),
    story.surfaces && keptTable(story, mask),
    story.executions?.length > 0 ? lightingTable(story, mask) : h('p', {}, 'Nothing is lit.'),
    story.resolve && h('p', {}, `Resolve: ${story.resolve.what}`),
    story.filter && h('div.story-body', {}, lumaPicture(story.filter), table('The filter', ['step', 'what'], story.filter.map(({kind, what}) => [kind, h('div.words', {}, what)]))),
    Object.keys(story.maps ?? {}).length > 0 && h('p.quiet', {}, `Maps here: ${Object.entries(story.maps).map(([name, value]) => `${name.replaceAll('_', ' ')} ${value}`).join(', ')}`));
}

// What breaks the parameters' own rules is what one looks for.
function stepText(what) {
  const words = 'against the parameters';
  const at = what.indexOf(words);
  return at < 0 ? what : [what.slice(0, at), h('strong.against', {}, words), what.slice(at + words.length)];
}

function samplesTable({pattern, fragments}, colourOf) {
  const byNumber = new Map(fragments.map((fragment) => [fragment.number, fragment]));
  return h('div.samples', {}, table('Samples', ['sample', ['at', 'pixels from the centre'], 'shows', 'triangle', ['reversed depth', '1 at the near plane, 0 at infinity']], pattern.map(({at, fragment, depth}, sample) => [
    sample, vector(at), fragment === null ? 'sky' : fragmentKey(fragment, colourOf), fragment === null ? '' : triangleCell(byNumber.get(fragment)?.triangle), fragment === null ? '' : significant(depth, 6)])));
}

function fragmentsTable({fragments: all}, colourOf, mask) {
  const fragments = all.filter(({covers}) => covers !== '0x0');
  const leaves = ({covers, alpha_leaves: left}) => left ?? covers;
  return [table('Fragments, in submission order',
    ['#', 'triangle', ['covers', 'samples of the triangle'], ['after alpha', 'samples that are left'], ['nearest so far', 'samples where it passes the depth test'], ['reversed depth', "of its plane at the pixel's centre"], 'normal', 'albedo', 'roughness'],
    foldedRows(fragments, ({passes}) => passes === '0x0', (fragment) => {
      const {number, triangle, covers, passes, plane, surface} = fragment;
      return [fragmentKey(number, colourOf), triangleCell(triangle), mask(covers, number), fragment.alpha_leaves ? mask(fragment.alpha_leaves, number) : 'all', mask(passes, number), significant(plane.depth, 6),
        vector(surface.normal, 2), linearColour(surface.albedo, 2), fixed(surface.roughness, 2)];
    }, (rows) => {
      const clear = rows.filter((fragment) => leaves(fragment) === '0x0').length;
      return `${rows.length} fragments (${numbersText(rows.map(({number}) => number))}): ${[clear > 0 && `alpha leaves no sample${clear < rows.length ? ` of ${clear}` : ''}`, clear < rows.length && `${clear > 0 ? `${rows.length - clear} ` : ''}behind what came before`].filter(Boolean).join(', ')}`;
    })),
  all.length > fragments.length && h('p.quiet', {}, `${all.length - fragments.length} more reach the pixel and cover none of its samples.`)];
}

// Surfaces, blocks, or aggregates, whose colours are split.
function keptTable({technique, surfaces}, mask) {
  const any = (test) => surfaces.some(test);
  const weighed = any(({weight}) => weight !== undefined);
  const split = any(({surface}) => surface.diffuse);
  const metal = any(({surface}) => surface.metallic > 0);
  const shines = any(({surface}) => surface.emissive?.some((value) => value > 0));
  const depths = surfaces[0]?.depth_of ?? 'depth';
  return table('Kept', [slotName(technique), 'covers', ...(weighed ? ['weight'] : []), depths, 'normal', ...(split ? ['diffuse', 'reflectance'] : ['albedo']), 'roughness', ...(metal ? ['metallic'] : []), ...(shines ? ['emissive'] : [])],
    surfaces.map(({slot, covers, weight, nearest, farthest, surface}) => [slot, mask(covers), ...(weighed ? [weight] : []),
      `${significant(nearest, 5)} to ${significant(farthest, 5)}`, vector(surface.normal, 2),
      ...(split ? [linearColour(surface.diffuse, 2), linearColour(surface.reflectance, 2)] : [linearColour(surface.albedo, 2)]), fixed(surface.roughness, 2),
      ...(metal ? [fixed(surface.metallic, 2)] : []), ...(shines ? [vector(surface.emissive)] : [])]));
}

const slotName = (technique) => ({agaa: 'aggregate', linked_list: 'block'}[technique] ?? 'surface');

// What is lit once: a slot that was kept, else a sample, or a fragment where several samples show it.
function lightingTable({technique, executions, surfaces, samples}, mask) {
  const one = ({of, samples: lit}) => of < samples && samplesOf(lit).includes(of);
  const name = surfaces ? slotName(technique) : ['forward', 'visibility', 'dais'].includes(technique) || !executions.every(one) ? 'fragment' : 'sample';
  return table('Lighting', [name, 'for samples', ['weight', 'in the resolve'], 'radiance'], executions.map(({of, samples: lit, weight, value}) => [of, mask(lit), weight, linearColour(value, 4)]));
}

function definitionTable({definition}) {
  return table('Distances by which samples were grouped', ['sample', 'aggregate', 'from the mean', 'from seeds'], definition.samples.map(({aggregate, from_mean: mean, from_seeds: seeds}, sample) => (aggregate === null
    ? [sample, 'sky', '', ''] : [sample, aggregate, significant(Math.max(0, mean), 4), seeds.map((value) => significant(Math.max(0, value), 4)).join(', ')])));
}

// The 3x3 pixels whose luma a filter looks at, as greys with their values.
function lumaPicture(filter) {
  const neighbourhood = filter.find((step) => step.neighbourhood)?.neighbourhood;
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

const triangleCell = (triangle) => triangle && h('div.words', {}, triangleText(triangle));

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
  const rows = [...parts].sort(([, a], [, b]) => b.samples - a.samples).map(([name, part]) => [name, part.samples, part.shadings, linearColour(part.sum.map((value) => value / part.samples), 4)].map((cell, i) => (i === 0 ? h('div.words', {}, cell) : cell)));
  const sky = reference.samples - [...parts.values()].reduce((sum, part) => sum + part.samples, 0);
  return h('article.story', {}, h('h3', {}, 'reference', h('span.quiet', {}, ` ${reference.samples} samples`)),
    h('div.story-body', {}, shadingsPicture(reference.shadings), table('Shading samples by triangle', ['triangle', ['samples', 'of visibility'], 'shadings', ['mean radiance', 'over the samples']],
      [...rows, ...(sky > 0 ? [['sky', sky, '', '']] : [])])));
}
