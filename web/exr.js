// Reads OpenEXR files of scanlines as the service stores them (openexr.com, "OpenEXR File Layout"): linear images of half
// floats, and maps of counts or values in the channel Y. Compression none, ZIPS or ZIP, which the browser inflates.

const types = ['uint', 'half', 'float'];
const sizes = [4, 2, 4];
const linesOf = {0: 1, 2: 1, 3: 16};
const maxPixels = 2 ** 28;

/** A half float's bits as a number (IEEE 754, binary16). */
export function halfToNumber(bits) {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

let halves = null;
function halfTable() {
  halves ??= Float32Array.from({length: 65536}, (_, bits) => halfToNumber(bits));
  return halves;
}

class Reader {
  constructor(buffer) {
    this.view = new DataView(buffer);
    this.bytes = new Uint8Array(buffer);
    this.at = 0;
  }
  int() {
    this.at += 4;
    return this.view.getInt32(this.at - 4, true);
  }
  text() {
    const end = this.bytes.indexOf(0, this.at);
    if (end < 0 || end - this.at > 255) throw new Error('the EXR file is damaged: a name does not end');
    const text = String.fromCharCode(...this.bytes.subarray(this.at, end));
    this.at = end + 1;
    return text;
  }
}

function readHeader(reader) {
  if (reader.int() !== 20000630) throw new Error('this is no EXR file');
  if (reader.int() & 0x1a00) throw new Error('EXR files of tiles, several parts or deep data are not read');
  const header = {unit: ''};
  for (let name = reader.text(); name; name = reader.text()) {
    reader.text();  // its type, which the name says as well
    const size = reader.int();
    const start = reader.at;
    if (name === 'channels') header.channels = readChannels(reader);
    else if (name === 'compression') header.compression = reader.bytes[start];
    else if (name === 'dataWindow') header.window = [reader.int(), reader.int(), reader.int(), reader.int()];
    else if (name === 'unit') header.unit = new TextDecoder().decode(reader.bytes.subarray(start, start + size));
    reader.at = start + size;
  }
  const [left, top, right, bottom] = header.window;
  Object.assign(header, {top, width: right - left + 1, height: bottom - top + 1});
  const pixels = header.width * header.height;
  if (!(header.width > 0 && header.height > 0 && pixels <= maxPixels)) throw new Error('the EXR file is damaged: its size');
  if (!(header.compression in linesOf)) throw new Error('an EXR file of this compression is not read');
  return header;
}

function readChannels(reader) {
  const channels = [];
  for (let name = reader.text(); name; name = reader.text()) {
    const type = reader.int();
    reader.at += 4;
    if (reader.int() !== 1 || reader.int() !== 1) throw new Error('EXR files of thinned channels are not read');
    channels.push({name, type});
  }
  return channels;
}

async function inflate(bytes, size) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  const packed = new Uint8Array(await new Response(stream).arrayBuffer());
  if (packed.length !== size) throw new Error('the EXR file is damaged: a block has another size');
  // Each byte was stored as the difference to the one before, and even and odd bytes apart.
  for (let i = 1; i < size; ++i) packed[i] = packed[i - 1] + packed[i] - 128;
  const out = new Uint8Array(size);
  const half = (size + 1) >> 1;
  for (let i = 0; i < half; ++i) out[2 * i] = packed[i];
  for (let i = half; i < size; ++i) out[2 * (i - half) + 1] = packed[i];
  return out;
}

/**
 * @param {ArrayBuffer} buffer the file
 * @returns {Promise<{width, height, names, type, unit, planes}>} planes in the order R, G, B, A or Y: Float32Array, of counts
 *   Uint32Array, row-major from the top left; `type` is that of the first channel: half, float or uint
 */
export async function readExr(buffer) {
  const reader = new Reader(buffer);
  const {channels, compression, top, width, height, unit} = readHeader(reader);
  const lineBytes = channels.reduce((sum, {type}) => sum + sizes[type] * width, 0);
  const planes = channels.map(({type}) => (type === 0 ? new Uint32Array(width * height) : new Float32Array(width * height)));
  const lines = linesOf[compression];
  const blocks = Math.ceil(height / lines);
  reader.at += 8 * blocks;  // the blocks' places; they come one after the other
  const waiting = [];
  for (let block = 0; block < blocks; ++block) {
    const first = reader.int() - top;
    const size = reader.int();
    const bytes = reader.bytes.subarray(reader.at, reader.at + size);
    reader.at += size;
    const count = Math.min(lines, height - first);
    if (bytes.length !== size || first < 0 || !(count > 0)) throw new Error('the EXR file is damaged: it is cut short');
    const whole = count * lineBytes;
    waiting.push((size < whole ? inflate(bytes, whole) : Promise.resolve(bytes.slice())).then((raw) =>
      takeLines(raw, {first, count, width, channels, planes})));
  }
  await Promise.all(waiting);
  const order = ['R', 'G', 'B', 'A', 'Y'];
  const sorted = channels.map(({name, type}, i) => ({name, type, plane: planes[i]})).sort((a, b) => order.indexOf(a.name) - order.indexOf(b.name));
  return {width, height, unit, type: types[sorted[0].type], names: sorted.map(({name}) => name), planes: sorted.map(({plane}) => plane)};
}

function takeLines(raw, {first, count, width, channels, planes}) {
  const table = halfTable();
  const view = new DataView(raw.buffer, raw.byteOffset, raw.byteLength);
  let at = 0;
  for (let y = first; y < first + count; ++y) {
    channels.forEach(({type}, c) => {
      const plane = planes[c];
      const row = y * width;
      if (type === 1) for (let x = 0; x < width; ++x, at += 2) plane[row + x] = table[raw[at] | (raw[at + 1] << 8)];
      else if (type === 2) for (let x = 0; x < width; ++x, at += 4) plane[row + x] = view.getFloat32(at, true);
      else for (let x = 0; x < width; ++x, at += 4) plane[row + x] = view.getUint32(at, true);
    });
  }
}
