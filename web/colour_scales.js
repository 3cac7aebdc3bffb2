// The legends of maps and their colours, which are the service's.
import {palette} from './api.js';
import {h} from './dom.js';
import {significant} from './format.js';

const rgb = (colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));

/** Colour of `t` in 0..1 as [r, g, b] in 0..255. */
export function colourAt(map, t) {
  const colours = coloursOf(map);
  const at = Math.min(Math.max(t, 0), 1) * (colours.length - 1);
  const below = Math.min(Math.floor(at), colours.length - 2);
  const [low, high] = [rgb(colours[below]), rgb(colours[below + 1])];
  return low.map((value, i) => value + (at - below) * (high[i] - value));
}

const coloursOf = (map) => (map === 'grey' ? ['#000000', '#ffffff'] : palette(map));

const known = {
  error: {title: 'Error', description: 'largest absolute difference of the sRGB channels to the reference', unit: '', map: 'magma', maximum: 0.25},
  flip: {title: 'FLIP', description: 'difference a person sees when image and reference alternate (FLIP)', unit: '', map: 'magma', maximum: 1},
  shading: {title: 'Shading', description: 'lighting executions per pixel', unit: 'executions', map: 'viridis', maximum: 0, discrete: true},
};

/** The scale of the map `role` of a result, or null when the role is no map. `technique` is the registry's entry. */
export function scaleOf(role, technique, result) {
  const declared = technique?.maps?.find((map) => map.name === role);
  const base = known[role] ?? (declared && {map: 'viridis', discrete: true, description: declared.title});
  if (!base) return null;
  const scale = {...base, title: base.title ?? declared?.title ?? role, unit: declared?.unit || base.unit || ''};
  if (declared && role !== 'error') scale.maximum = declared.maximum;
  if (!scale.maximum) scale.maximum = Math.max(1, result.samples);
  return scale;
}

/** A bar of the scale's colours with numbers and unit. */
export function legend(scale) {
  const bar = h('div.legend-bar', {});
  if (scale.discrete && scale.maximum <= 64) {
    const stops = [];
    for (let i = 0; i <= scale.maximum; ++i) {
      const colour = css(colourAt(scale.map, i / scale.maximum));
      stops.push(`${colour} ${(100 * i) / (scale.maximum + 1)}% ${(100 * (i + 1)) / (scale.maximum + 1)}%`);
    }
    bar.style.background = `linear-gradient(to right, ${stops.join(', ')})`;
  } else {
    bar.style.background = `linear-gradient(to right, ${coloursOf(scale.map).join(', ')})`;
  }
  return h('figure.legend', {},
    h('figcaption', {}, scale.description, scale.unit && ` (${scale.unit})`),
    bar, h('div.legend-ticks', {class: scale.discrete ? 'discrete' : ''}, ticks(scale).map(({value, share}, i, all) => {
      const last = i === all.length - 1;
      const tick = h('span', {}, `${last ? '≥ ' : ''}${significant(value, value % 1 ? 3 : 4).replace(/\.0+$|(\.\d*?)0+$/, '$1')}`);
      tick.style.left = `${100 * share}%`;
      return tick;
    })));
}

function ticks({low = 0, maximum, discrete, log}) {
  if (!discrete || maximum > 64) {
    const from = low > 0 ? low : maximum / 1000;
    return [0, 0.25, 0.5, 0.75, 1].map((share) => ({value: log ? from * (maximum / from) ** share : low + share * (maximum - low), share}));
  }
  const step = Math.max(1, Math.ceil(maximum / 8));
  const values = [];
  for (let value = 0; value < maximum; value += step) values.push(value);
  if (maximum - values.at(-1) < step / 2) values.pop();
  values.push(maximum);
  return values.map((value) => ({value, share: (value + 0.5) / (maximum + 1)}));
}

const css = (colour) => `rgb(${colour.map(Math.round).join(' ')})`;
