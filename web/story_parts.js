// Pieces of a pixel's story: fragments by their colours, masks and the pattern as pictures, colours, tables, and rows that are
// folded because nothing of them shows.
import {h, replace} from './dom.js';
import {fixed, significant} from './format.js';
import {colours, s} from './svg.js';

const edge = 0.5;  // of the pixel, from its centre

export const vector = (values, digits = 3) => values.map((value) => fixed(value, digits)).join(' ');

const clamped = (value) => Math.min(Math.max(value, 0), 1);
const encoded = (value) => (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
const displayed = (linear) => linear.map((value) => encoded(clamped(value)));
const cssColour = (display) => `rgb(${display.map((value) => Math.round(255 * clamped(value))).join(' ')})`;

/** A colour of the display, 0 to 1 each channel. */
export function swatch(display) {
  const element = h('span.swatch', {'aria-hidden': true});
  element.style.background = cssColour(display);
  return element;
}

/** A linear colour: its numbers beside what the display makes of it, clamped. */
export const linearColour = (values, digits) => h('span.colour', {}, swatch(displayed(values)), vector(values, digits));

/** The samples of a mask, as numbers. */
export function samplesOf(mask) {
  const samples = [];
  for (let bits = BigInt(mask), sample = 0; bits > 0n; bits >>= 1n, ++sample) if (bits & 1n) samples.push(sample);
  return samples;
}

/** Colours of a story's fragments: those that show somewhere have one each while there are enough, the others are grey. */
export function fragmentColours({pattern, steps = [], fragments}) {
  const shown = new Set(pattern.map(({fragment}) => fragment).filter((fragment) => fragment !== null));
  for (const {fragment, kind} of steps) if (!dull.has(kind)) shown.add(fragment);
  for (const {number, passes} of fragments) if (passes !== '0x0') shown.add(number);
  const order = [...shown];
  return (fragment) => (shown.has(fragment) ? colours[order.indexOf(fragment) % colours.length] : '#8b95a5');
}

/** Kinds of steps that leave nothing of their fragment. */
export const dull = new Set(['transparent', 'hidden']);

export function fragmentKey(number, colourOf) {
  const key = h('span.key', {});
  key.style.background = colourOf(number);
  return h('span.fragment-key', {}, key, `${number}`);
}

const dots = (places, size) => places.map(([x, y]) => `M${(x - size).toFixed(3)} ${(y - size).toFixed(3)}h${2 * size}v${2 * size}h${-2 * size}z`).join('');

/** A mask as a small picture of the pixel, dots where its samples lie, and in hexadecimal. */
export function maskPicture(mask, pattern, colour = 'currentColor') {
  const samples = samplesOf(mask);
  // Masks of more samples than the pattern has (tables of 64 places) are told by their number alone.
  const known = samples.every((sample) => sample < pattern.length);
  const size = pattern.length > 16 ? 0.05 : 0.085;
  const words = `${samples.length} of ${pattern.length} samples${samples.length > 0 && samples.length <= 16 ? `: ${samples.join(', ')}` : ''}`;
  return h('span.mask', {}, known && s('svg', {viewBox: '-0.56 -0.56 1.12 1.12', class: 'mask-picture', role: 'img', 'aria-label': words},
    s('title', {}, words), s('rect', {x: -edge, y: -edge, width: 1, height: 1, class: 'pixel'}),
    s('path', {d: dots(pattern.map(({at}) => at), size), class: 'place'}),
    s('path', {d: dots(samples.map((sample) => pattern[sample].at), size), fill: colour})), mask);
}

/** The pixel as a square with its samples in the colours of the fragments that they show. */
export function patternPicture(pattern, colourOf) {
  const few = pattern.length <= 16;
  const told = (sample, {fragment, depth}) => `sample ${sample}: ${fragment === null ? 'sky' : `fragment ${fragment}, reversed depth ${significant(depth, 6)}`}`;
  return s('svg', {viewBox: '-0.56 -0.56 1.12 1.12', class: 'pattern', role: 'img', 'aria-label': `${pattern.length} samples on their pattern`},
    s('rect', {x: -edge, y: -edge, width: 1, height: 1, class: 'pixel'}),
    pattern.map((one, sample) => {
      const [x, y] = one.at;
      return [s('circle', {cx: x, cy: y, r: few ? 0.05 : 0.03, fill: one.fragment === null ? 'transparent' : colourOf(one.fragment), class: 'place'}, s('title', {}, told(sample, one))),
        few && s('text', {x: x > 0.38 ? x - 0.065 : x + 0.065, y: Math.min(Math.max(y, -0.44), 0.44) + 0.027, class: 'sample-number', 'text-anchor': x > 0.38 ? 'end' : 'start'}, `${sample}`)];
    }));
}

/** The pixel with the places where the reference shaded, in the colours that came out. */
export function shadingsPicture(shadings) {
  return s('svg', {viewBox: '-0.56 -0.56 1.12 1.12', class: 'pattern', role: 'img', 'aria-label': `${shadings.length} shadings in the pixel`},
    s('rect', {x: -edge, y: -edge, width: 1, height: 1, class: 'pixel'}),
    shadings.map(({at: [x, y], radiance, samples, triangle}) => s('circle', {cx: x, cy: y, r: 0.05, fill: cssColour(displayed(radiance)), class: 'place'},
      s('title', {}, `${triangleText(triangle)}: ${samples} samples, ${vector(radiance, 4)}`))));
}

export function triangleText({draw, instance, triangle, material, material_name: name, back_face: back, clipped}) {
  return `draw ${draw}, instance ${instance}, triangle ${triangle}, ${name ? `${name} (material ${material})` : `material ${material}`}${back ? ', back face' : ''}${clipped ? ', clipped' : ''}`;
}

/** A table in a region that scrolls by itself. `heads`: texts, or [text, what it means]. `rows` of cells, or rows that are made already. */
export function table(caption, heads, rows) {
  return h('div.scroll', {tabindex: 0, role: 'group', 'aria-label': caption}, h('table', {}, h('caption', {}, caption),
    h('thead', {}, h('tr', {}, heads.map((head) => (Array.isArray(head) ? h('th', {scope: 'col', title: head[1]}, head[0]) : h('th', {scope: 'col'}, head))))),
    h('tbody', {}, rows.map((cells) => (cells instanceof Node ? cells : row(cells))))));
}

const row = (cells) => h('tr', {}, cells.map((cell) => h('td', {}, cell)));

const foldedFrom = 3;

/** Rows of `items`, in their order; where three or more follow each other that are `isDull`, one row that opens them. */
export function foldedRows(items, isDull, cells, describe) {
  const rows = [];
  for (let i = 0; i < items.length;) {
    let end = i;
    while (end < items.length && isDull(items[end])) ++end;
    if (end - i < foldedFrom) {
      rows.push(row(cells(items[i++])));
      continue;
    }
    const hidden = items.slice(i, end).map((item) => row(cells(item)));
    const button = h('button.fold', {type: 'button', 'aria-expanded': 'false', onclick: () => {
      const open = button.getAttribute('aria-expanded') === 'false';
      button.setAttribute('aria-expanded', String(open));
      for (const one of hidden) one.hidden = !open;
    }}, describe(items.slice(i, end)));
    for (const one of hidden) one.hidden = true;
    rows.push(h('tr.folded', {}, h('td', {colspan: cells(items[i]).length}, button)), ...hidden);
    i = end;
  }
  return rows;
}

/** "1, 3 to 5": numbers that follow each other. */
export function numbersText(numbers) {
  const parts = [];
  for (let i = 0; i < numbers.length;) {
    let end = i;
    while (end + 1 < numbers.length && numbers[end + 1] === numbers[end] + 1) ++end;
    parts.push(end - i > 1 ? `${numbers[i]} to ${numbers[end]}` : numbers.slice(i, end + 1).join(', '));
    i = end + 1;
  }
  return parts.join(', ');
}

/** A part that is closed and made when it is opened. */
export function later(title, make) {
  const body = h('div', {});
  return h('details', {ontoggle: () => body.hasChildNodes() || replace(body, make())}, h('summary', {}, title), body);
}
