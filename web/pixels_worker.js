// Off the page's own thread: fetches and decodes pictures, colours them, and reads numbers out of them.
import {readExr} from './exr.js';
import {boxFigures, colourPicture, colourSigned, differenceOf, paletteTable, scalars, worstPlaces} from './pixel_math.js';

const budget = 320 * 2 ** 20;  // bytes of decoded pictures that are kept
const pictures = new Map();    // url or pair -> {promise, bytes}, least recently used first
const tables = new Map();

function remember(key, make) {
  const entry = pictures.get(key) ?? {promise: make(), bytes: 0};
  pictures.delete(key);
  pictures.set(key, entry);
  if (entry.bytes === 0) {
    entry.promise.then((picture) => {
      entry.bytes = picture.planes.reduce((sum, plane) => sum + plane.byteLength, 0);
      let held = 0;
      for (const [, {bytes}] of pictures) held += bytes;
      for (const [old, {bytes}] of pictures) {
        if (held <= budget || old === key) break;
        pictures.delete(old);
        held -= bytes;
      }
    }, () => pictures.delete(key));
  }
  return entry.promise;
}

async function fetchPicture({url, kind}) {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`the image could not be loaded: status ${response.status}`);
  if (kind !== 'display') return {kind, scale: 1, ...(await readExr(await response.arrayBuffer()))};
  const bitmap = await createImageBitmap(await response.blob(), {colorSpaceConversion: 'none', premultiplyAlpha: 'none'});
  const {width, height} = bitmap;
  const context = new OffscreenCanvas(width, height).getContext('2d', {willReadFrequently: true});
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  const {data} = context.getImageData(0, 0, width, height);
  const planes = [0, 1, 2].map((c) => {
    const plane = new Uint8Array(width * height);
    for (let i = 0; i < plane.length; ++i) plane[i] = data[4 * i + c];
    return plane;
  });
  return {kind, scale: 1 / 255, width, height, type: 'byte', unit: '', names: ['R', 'G', 'B'], planes};
}

const load = (layer) => remember(`${layer.kind} ${layer.url}`, () => fetchPicture(layer));

async function pair(a, b, measure) {
  const [first, second] = await Promise.all([load(a), load(b)]);
  return remember(`${a.url} - ${b.url} ${measure}`, async () => ({kind: 'map', scale: 1, width: first.width, height: first.height, planes: [differenceOf(first, second, measure)]}));
}

const tableOf = (colours) => {
  const key = String(colours);
  if (!tables.has(key)) tables.set(key, paletteTable(colours));
  return tables.get(key);
};

async function bitmapOf(rgba, width, height) {
  const bitmap = await createImageBitmap(new ImageData(rgba, width, height));
  return {result: {bitmap, width, height}, transfer: [bitmap]};
}

// The numbers whose sums a box and the list of places are about: a map's own, of an image its error to the reference.
async function measured(layer) {
  if (layer.kind === 'map') {
    const picture = await load(layer);
    return {...picture, values: scalars(picture)};
  }
  const picture = await pair(layer, layer.reference, 'largest');
  return {...picture, values: picture.planes[0]};
}

const operations = {
  /** A layer in colours. */
  async colour({layer, look}) {
    const picture = await load(layer);
    const palette = look.palette !== undefined ? {table: tableOf(look.palette)} : {};
    return bitmapOf(colourPicture(picture, {...look, ...palette}), picture.width, picture.height);
  },
  /** The difference of two layers in colours: `palette` over 0 to 1 / gain, or with sign. */
  async difference({a, b, measure, signed, gain, palette}) {
    const {planes: [values], width, height} = await pair(a, b, measure);
    if (signed) return bitmapOf(colourSigned(values, gain), width, height);
    const picture = {width, height, scale: 1, kind: 'map', planes: [values.map(Math.abs)]};
    return bitmapOf(colourPicture(picture, {table: tableOf(palette), low: 0, high: 1 / gain}), width, height);
  },
  /** What each layer holds at a pixel: {values, type, unit}, null outside. */
  async values({layers, x, y}) {
    return {result: await Promise.all(layers.map(async (layer) => {
      const {width, height, planes, scale, type, unit, kind} = await load(layer);
      if (x < 0 || y < 0 || x >= width || y >= height) return null;
      return {values: planes.slice(0, 3).map((plane) => plane[y * width + x] * scale), type, unit, kind};
    }))};
  },
  /** The difference of two layers at a pixel. */
  async differenceAt({a, b, measure, x, y}) {
    const {planes: [values], width} = await pair(a, b, measure);
    return {result: values[y * width + x]};
  },
  /** The values of a small part, row by row, each a list of channels. */
  async region({layer, x, y, width, height}) {
    const picture = await load(layer);
    const rows = [];
    for (let row = y; row < y + height; ++row) {
      rows.push(Array.from({length: width}, (_, i) => picture.planes.slice(0, 3).map((plane) => plane[row * picture.width + x + i] * picture.scale)));
    }
    return {result: rows};
  },
  /** Figures of a box, for each layer (null where it has neither numbers of its own nor a reference). */
  async box({layers, box}) {
    return {result: await Promise.all(layers.map(async (layer) => {
      if (layer.kind !== 'map' && !layer.reference) return null;
      const {values, width} = await measured(layer);
      return boxFigures(values, width, box, layer.kind === 'map' ? layer.high : 0.25);
    }))};
  },
  async worst({layer}) {
    const {values, width, height} = await measured(layer);
    return {result: worstPlaces(values, width, height)};
  },
  /** The mean of a difference, for tests and readers of the page. */
  async meanDifference({a, b, measure}) {
    const {planes: [values]} = await pair(a, b, measure);
    return {result: values.reduce((sum, value) => sum + Math.abs(value), 0) / values.length};
  },
};

onmessage = async ({data: {id, operation, request}}) => {
  try {
    const {result, transfer = []} = await operations[operation](request);
    postMessage({id, result}, transfer);
  } catch (error) {
    postMessage({id, error: error.message});
  }
};
