// Images of numbers: how they are coloured and what is measured of them. Pure functions, which the page's worker calls.
//
// A picture is {width, height, planes, scale, kind}: planes of numbers, row-major from the top left; a value is
// planes[c][i] * scale. `kind`: "display" (sRGB-encoded, 0 to 1), "linear" (scene light) or "map" (one plane).
import {flipMap} from './flip.js';

export const srgbEncode = (v) => (v > 0 ? (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055) : 0);
export const srgbDecode = (v) => (v > 0 ? (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4) : 0);

// ACES: Narkowicz' fit, 2015. Both bring scene light into 0..1.
const tones = {
  none: (v) => v,
  reinhard: (v) => v / (1 + v),
  aces: (v) => (v * (2.51 * v + 0.03)) / (v * (2.43 * v + 0.59) + 0.14),
};
export const toneNames = Object.keys(tones);

// sRGB bytes by the square root of linear values in 0..1: near black, where the curve is steep, the table is fine.
const encodeSteps = 4096;
const encoded = Uint8ClampedArray.from({length: encodeSteps + 1}, (_, i) => 255 * srgbEncode((i / encodeSteps) ** 2));
const decoded = Float32Array.from({length: 256}, (_, i) => srgbDecode(i / 255));
const notFinite = [255, 0, 255];

/** `count` numbers; a plain loop, for Float32Array.from takes many times as long. */
function numbers(count, of) {
  const out = new Float32Array(count);
  for (let i = 0; i < count; ++i) out[i] = of(i);
  return out;
}

const channelIndex = {r: 0, g: 1, b: 2};

const grey = Array.from({length: 18}, (_, i) => i / 17).map((t) => `#${Math.round(255 * t).toString(16).padStart(2, '0').repeat(3)}`);

/** 1024 colours of a palette ("#rrggbb", evenly spaced, linear between) as bytes. */
export function paletteTable(colours) {
  const points = (colours ?? grey).map((colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));
  const table = new Uint8ClampedArray(3 * 1024);
  for (let i = 0; i < 1024; ++i) {
    const at = (i / 1023) * (points.length - 1);
    const below = Math.min(Math.floor(at), points.length - 2);
    for (let c = 0; c < 3; ++c) table[3 * i + c] = points[below][c] + (at - below) * (points[below + 1][c] - points[below][c]);
  }
  return table;
}

/** Where `value` lies between low and high, 0 to 1; with `log` on a logarithmic scale that begins at a thousandth of high. */
export function share(value, {low, high, log}) {
  if (!log) return (value - low) / (high - low || 1);
  const from = low > 0 ? low : high / 1000;
  return value > 0 ? Math.log(value / from) / Math.log(high / from || 2) : 0;
}

/** One number for each pixel: of a map its own, of an image that of a channel ("r", "g", "b"), else the luminance (Rec. 709). */
export function scalars(picture, channel) {
  const {planes, scale} = picture;
  if (planes.length < 3) return scale === 1 ? planes[0] : numbers(planes[0].length, (i) => planes[0][i] * scale);
  const [r, g, b] = planes;
  const one = planes[channelIndex[channel]];
  return numbers(r.length, (i) => scale * (one ? one[i] : 0.2126 * r[i] + 0.7152 * g[i] + 0.0722 * b[i]));
}

/** Display values of a colour image without exposure or tone: clamped and sRGB-encoded when it is linear. */
export function displayPlanes({planes, scale, kind}) {
  const colours = planes.length < 3 ? [planes[0], planes[0], planes[0]] : planes.slice(0, 3);
  return colours.map((plane) => numbers(plane.length, kind === 'linear' ? (i) => srgbEncode(Math.min(plane[i] * scale, 1)) : (i) => plane[i] * scale));
}

function colourScalars(values, {low = 0, high = 1, log = false, table}) {
  const out = new Uint8ClampedArray(4 * values.length);
  for (let i = 0; i < values.length; ++i) {
    const t = share(values[i], {low, high, log});
    const at = 3 * (t > 0 ? Math.min(Math.round(t * 1023), 1023) : 0);
    const bad = !Number.isFinite(values[i]);
    for (let c = 0; c < 3; ++c) out[4 * i + c] = bad ? notFinite[c] : table[at + c];
    out[4 * i + 3] = 255;
  }
  return out;
}

/**
 * The picture in colours, as RGBA bytes. `look`: {exposure, tone, channel, table, low, high, log}; with a `table` (of
 * paletteTable) numbers become its colours, else light becomes sRGB.
 */
export function colourPicture(picture, look) {
  if (picture.planes.length < 3 || look.table) return colourScalars(scalars(picture, look.channel), look);
  const {planes, scale, kind} = picture;
  const count = planes[0].length;
  const out = new Uint8ClampedArray(4 * count);
  const one = channelIndex[look.channel];
  const factor = 2 ** (look.exposure ?? 0);
  const tone = tones[look.tone ?? 'none'];
  const luminance = look.channel === 'luminance';
  const bytes = scale !== 1;
  const plain = kind === 'display' && factor === 1 && tone === tones.none && !luminance;
  const lightOf = kind === 'linear' ? (v) => v * scale : bytes ? (v) => decoded[v] : srgbDecode;
  const source = luminance ? numbers(count, (i) => 0.2126 * lightOf(planes[0][i]) + 0.7152 * lightOf(planes[1][i]) + 0.0722 * lightOf(planes[2][i])) : null;
  const toByte = (v) => encoded[v > 0 ? Math.round(Math.sqrt(Math.min(v, 1)) * encodeSteps) : 0];
  for (let c = 0; c < 3; ++c) {
    const plane = source ?? planes[one ?? c];
    for (let i = 0; i < count; ++i) {
      out[4 * i + c] = plain ? (bytes ? plane[i] : 255 * plane[i]) : toByte(tone((source ? plane[i] : lightOf(plane[i])) * factor));
    }
  }
  for (let i = 0; i < count; ++i) out[4 * i + 3] = 255;
  if (kind === 'linear') {
    for (let i = 0; i < count; ++i) {
      if (!Number.isFinite(planes[0][i] + planes[1][i] + planes[2][i])) out.set(notFinite, 4 * i);
    }
  }
  return out;
}

/**
 * How much `a` is above `b`: one plane for the measures "r", "g", "b", "luminance", "mean" (all signed), "largest" (of the
 * channels' absolute differences) and "flip". Maps are subtracted as they are, images as display values.
 */
export function differenceOf(a, b, measure) {
  if (a.width !== b.width || a.height !== b.height) throw new Error(`the sizes differ: ${a.width}×${a.height} and ${b.width}×${b.height}`);
  if (a.kind === 'map' && b.kind === 'map') {
    const [p, q] = [scalars(a), scalars(b)];
    return numbers(p.length, (i) => p[i] - q[i]);
  }
  if (a.kind === 'map' || b.kind === 'map') throw new Error('a map and an image have no difference');
  const [p, q] = [displayPlanes(a), displayPlanes(b)];
  if (measure === 'flip') {
    const light = (planes) => planes.map((plane) => plane.map((v) => srgbDecode(Math.min(v, 1))));
    return flipMap(light(p), light(q), a.width, a.height);
  }
  const of = {
    r: (d) => d[0], g: (d) => d[1], b: (d) => d[2], mean: (d) => (d[0] + d[1] + d[2]) / 3,
    luminance: (d) => 0.2126 * d[0] + 0.7152 * d[1] + 0.0722 * d[2],
    largest: (d) => Math.max(Math.abs(d[0]), Math.abs(d[1]), Math.abs(d[2])),
  }[measure];
  const d = [0, 0, 0];
  return numbers(p[0].length, (i) => {
    for (let c = 0; c < 3; ++c) d[c] = p[c][i] - q[c][i];
    return of(d);
  });
}

/** Blue below 0, black at 0, orange above, full at 1 / gain. */
export function colourSigned(values, gain) {
  const out = new Uint8ClampedArray(4 * values.length);
  for (let i = 0; i < values.length; ++i) {
    const v = Math.max(-1, Math.min(1, values[i] * gain));
    out.set(v < 0 ? [-70 * v, -160 * v, -255 * v, 255] : [255 * v, 150 * v, 40 * v, 255], 4 * i);
  }
  return out;
}

/** Sums over a box {x, y, width, height}: mean, largest, share of the whole's sum, a histogram of 24 steps up to `high`. */
export function boxFigures(values, width, box, high) {
  let [whole, inside, largest, count] = [0, 0, 0, 0];
  for (let i = 0; i < values.length; ++i) whole += values[i];
  const histogram = new Array(24).fill(0);
  for (let y = box.y; y < box.y + box.height; ++y) {
    for (let x = box.x; x < box.x + box.width; ++x) {
      const v = values[y * width + x];
      inside += v;
      largest = Math.max(largest, v);
      ++count;
      ++histogram[Math.min(23, Math.max(0, Math.floor((24 * v) / high)))];
    }
  }
  return {sum: inside, mean: inside / count, largest, share: whole > 0 ? inside / whole : 0, pixels: count, histogram, high};
}

/** The `most` worst places: squares of `side` pixels by their sum, each with its largest pixel; none that are all 0. */
export function worstPlaces(values, width, height, most = 50, side = 16) {
  const places = [];
  for (let top = 0; top < height; top += side) {
    for (let left = 0; left < width; left += side) {
      const place = {sum: 0, value: -1, x: left, y: top};
      for (let y = top; y < Math.min(top + side, height); ++y) {
        for (let x = left; x < Math.min(left + side, width); ++x) {
          const v = values[y * width + x];
          place.sum += v;
          if (v > place.value) Object.assign(place, {value: v, x, y});
        }
      }
      if (place.sum > 0) places.push(place);
    }
  }
  return places.sort((a, b) => b.sum - a.sum).slice(0, most);
}
