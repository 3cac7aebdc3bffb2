// Plots as SVG: axes, points and lines. The same drawing is on the page and in files.
import {significant} from './format.js';

const space = 'http://www.w3.org/2000/svg';

/** An element of SVG; attributes as given, children as in dom.js's h(). */
export function s(tag, attributes = {}, ...children) {
  const element = document.createElementNS(space, tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

// Okabe and Ito's palette, which colour-blind people can tell apart.
export const colours = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#56b4e9', '#e69f00', '#7a7a7a', '#b8a800', '#7b4ab5', '#a0522d', '#2f8f8f', '#c0392b'];

/** The range of `values`, a little wider; the logarithm of it when `log`. */
export function scaleOf(values, log, from, to) {
  const usable = values.filter((v) => Number.isFinite(v) && (!log || v > 0));
  const of = log ? Math.log10 : (v) => v;
  let [low, high] = usable.length > 0 ? [of(Math.min(...usable)), of(Math.max(...usable))] : [0, 1];
  const margin = (high - low) * 0.06 || Math.abs(high) * 0.1 || 0.5;
  low = !log && low >= 0 && low - margin < 0 ? 0 : low - margin;
  high += margin;
  const place = (v) => from + ((of(v) - low) / (high - low)) * (to - from);
  return {place, low, high, log, shows: (v) => Number.isFinite(v) && (!log || v > 0)};
}

function ticksOf({low, high, log}) {
  if (log && high - low >= 1) {
    const ticks = [];
    const steps = high - low < 2.2 ? [1, 2, 5] : [1];
    for (let power = Math.floor(low); power <= high; ++power) for (const step of steps) ticks.push(step * 10 ** power);
    return ticks.filter((v) => Math.log10(v) >= low && Math.log10(v) <= high);
  }
  const [from, to] = log ? [10 ** low, 10 ** high] : [low, high];
  const rough = (to - from) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough) * power;
  const ticks = [];
  for (let v = Math.ceil(from / step) * step; v <= to + step * 1e-9; v += step) ticks.push(Math.abs(v) < step * 1e-9 ? 0 : v);
  return ticks;
}

export function tickText(value) {
  const size = Math.abs(value);
  if (value !== 0 && (size >= 1e5 || size < 1e-3)) return value.toExponential(0).replace('e+', 'e');
  return significant(value, 3).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
}

/** {frame, x, y, box}: an empty plot with axes over the given values. */
export function axes({width, height, xs, ys, logX, logY, titleX, titleY}) {
  const box = {left: 66, top: 14, right: width - 16, bottom: height - 46};
  const x = scaleOf(xs, logX, box.left, box.right);
  const y = scaleOf(ys, logY, box.bottom, box.top);
  const text = {'font-size': 12, fill: 'currentColor', 'font-family': 'system-ui, sans-serif'};
  const line = {stroke: 'currentColor', 'stroke-opacity': 0.16};
  const frame = s('g', {},
    ticksOf(x).map((v) => [s('line', {...line, x1: x.place(v), x2: x.place(v), y1: box.top, y2: box.bottom}),
      s('text', {...text, x: x.place(v), y: box.bottom + 17, 'text-anchor': 'middle'}, tickText(v))]),
    ticksOf(y).map((v) => [s('line', {...line, x1: box.left, x2: box.right, y1: y.place(v), y2: y.place(v)}),
      s('text', {...text, x: box.left - 7, y: y.place(v) + 4, 'text-anchor': 'end'}, tickText(v))]),
    s('text', {...text, x: (box.left + box.right) / 2, y: height - 8, 'text-anchor': 'middle', 'font-weight': 600}, titleX),
    s('text', {...text, transform: `translate(15 ${(box.top + box.bottom) / 2}) rotate(-90)`, 'text-anchor': 'middle', 'font-weight': 600}, titleY));
  return {frame, x, y, box};
}

/** The drawing as a file's text: what the page's colours made of it is written out. */
export function svgText(svg) {
  const copy = svg.cloneNode(true);
  copy.setAttribute('color', '#16202e');
  copy.querySelectorAll('[tabindex]').forEach((element) => element.removeAttribute('tabindex'));
  return new XMLSerializer().serializeToString(copy);
}
