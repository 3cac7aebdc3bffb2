// What a comparison can be set to, and what pictures a state asks the worker for. Layers: {key, label, url, kind:
// display|linear|map, scale (of maps), reference (a layer that it is an error to)}.
import {palette} from './api.js';
import {count, fixed, scientific, significant} from './format.js';

export const maxLayers = 6;
export const zoomSteps = [1, 2, 4, 8, 16, 32, 64];
/** The ways to compare: title and key. */
export const modes = {wipe: ['Wipe', 'w'], flip: ['Flip', 'f'], side: ['Side by side', 's'], difference: ['Difference', 'd']};
export const measures = {largest: 'largest channel', luminance: 'luminance', mean: 'mean of channels', r: 'red', g: 'green', b: 'blue', flip: 'FLIP'};
export const signless = ['largest', 'flip'];
export const channels = {all: 'colour', r: 'red', g: 'green', b: 'blue', luminance: 'luminance'};
/** How numbers are coloured when nothing was chosen. */
export const plainLook = {exposure: 0, tone: 'none', channel: 'all', falseColour: false, log: false, palette: '', low: null, high: null};
export const firstState = {mode: 'wipe', a: 0, b: 1, share: 0.5, scale: 0, cx: null, cy: null, box: null, measure: 'largest', signed: false, gain: 4, magnify: false, worst: false, ...plainLook};

export const isMap = (layer) => layer?.kind === 'map';
/** A layer as the worker wants it. */
export const source = ({url, kind}) => ({url, kind});

/** A value as text: counts whole, bytes as shares of 1, others to four digits. */
export function valueText(value, type) {
  if (!Number.isFinite(value)) return String(value);
  if (type === 'uint') return count(value);
  if (type === 'byte') return fixed(value, 3);
  return value !== 0 && Math.abs(value) < 1e-3 ? scientific(value) : significant(value, 4);
}

/** The scale that a layer's numbers are coloured by: its own where nothing else was chosen. */
export function scaleIn({palette: named, low, high, log}, layer) {
  const own = layer.scale ?? {map: 'viridis', maximum: 1, discrete: false, description: `${layer.label}: luminance`, unit: ''};
  const changed = low !== null || high !== null || log;
  return {...own, map: named || own.map, low: low ?? 0, maximum: high ?? own.maximum, log, discrete: own.discrete && !changed};
}

/** A layer in colours: {operation, request} of pixels.js. */
export function coloured(state, layer) {
  const {exposure, tone, channel, falseColour, log} = state;
  const look = () => {
    if (!isMap(layer) && !falseColour) return layer.kind === 'linear' || exposure !== 0 || tone !== 'none' || channel !== 'all' ? {exposure, tone, channel} : {};
    const scale = scaleIn(state, layer);
    return {palette: scale.map === 'grey' ? null : palette(scale.map), low: scale.low, high: scale.maximum, log, channel};
  };
  return {operation: 'colour', request: {layer: source(layer), look: look()}};
}

/** The pictures that a state shows of its layers: [{layers, label, operation, request}]. */
export function picturesOf(state, layers) {
  const {mode, a, b, measure, signed, gain} = state;
  const plain = (layer) => ({layers: [layer], label: layer.label, ...coloured(state, layer)});
  if (layers.length < 2 || mode === 'side') return layers.map(plain);
  const [first, second] = [layers[a], layers[b]];
  if (mode === 'flip') return [plain(first)];
  if (mode === 'wipe') return a === b ? [plain(first)] : [plain(first), plain(second)];
  const withSign = signed && !signless.includes(measure);
  return [{layers: [first, second], operation: 'difference',
    label: `${first.label} − ${second.label}: ${isMap(first) ? 'numbers' : measures[measure]}${withSign ? ', signed' : ''}, ×${gain}`,
    request: {a: source(first), b: source(second), measure, signed: withSign, gain, palette: palette('magma')}}];
}
