// A service whose results are made up: the viewer's files with the real service's headers, and its API over runs of any size.
// Every pixel is known, so tests can say what the page has to show of it.
import {createServer} from 'node:http';
import {existsSync, readFileSync} from 'node:fs';
import {extname, join} from 'node:path';
import {deflateSync, crc32} from 'node:zlib';
import {madeUpStory} from './made_up_story.mjs';

const web = join(import.meta.dirname, '../../web');
const media = {'.html': 'text/html; charset=utf-8', '.css': 'text/css; charset=utf-8', '.js': 'text/javascript; charset=utf-8', '.svg': 'image/svg+xml'};
// As server/api.cpp has it; the test that compares them is in viewer_test.mjs.
export const policy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

// Files ---------------------------------------------------------------------------------------------------------------

function png(width, height, rgb) {
  const rows = Buffer.alloc((3 * width + 1) * height);
  for (let y = 0; y < height; ++y) rgb.copy(rows, y * (3 * width + 1) + 1, 3 * width * y, 3 * width * (y + 1));
  const chunk = (type, payload) => {
    const body = Buffer.concat([Buffer.from(type), payload]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(payload.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 2], 8);
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', head), chunk('IDAT', deflateSync(rows, {level: 1})), chunk('IEND', Buffer.alloc(0))]);
}

/** A number as the bits of a half float, by truncation. */
export function toHalf(value) {
  if (value === 0) return 0;
  const exponent = Math.max(-14, Math.min(15, Math.floor(Math.log2(Math.abs(value)))));
  const sign = value < 0 ? 0x8000 : 0;
  const fraction = Math.abs(value) / 2 ** exponent;
  return fraction < 1 ? sign | Math.floor(fraction * 1024) : sign | ((exponent + 15) << 10) | Math.floor((fraction - 1) * 1024);
}
export const fromHalf = (bits) => (bits & 0x7c00 ? 2 ** ((bits >> 10 & 31) - 15) * (1 + (bits & 1023) / 1024) : (bits & 1023) * 2 ** -24);

/** An OpenEXR file, zip-compressed: `channels` {NAME: (x, y) -> number}, of type uint, half or float. */
export function exr(width, height, channels, type, unit) {
  const number = (value) => {
    const bytes = Buffer.alloc(4);
    bytes.writeInt32LE(value);
    return bytes;
  };
  const attribute = (name, kind, payload) => Buffer.concat([Buffer.from(`${name}\0${kind}\0`), number(payload.length), payload]);
  const names = Object.keys(channels).sort();
  const code = ['uint', 'half', 'float'].indexOf(type);
  const window = Buffer.concat([0, 0, width - 1, height - 1].map(number));
  const header = Buffer.concat([number(20000630), number(2),
    attribute('channels', 'chlist', Buffer.concat([...names.flatMap((name) => [Buffer.from(`${name}\0`), number(code), Buffer.alloc(4), number(1), number(1)]), Buffer.from([0])])),
    attribute('compression', 'compression', Buffer.from([3])), attribute('dataWindow', 'box2i', window), attribute('displayWindow', 'box2i', window),
    attribute('lineOrder', 'lineOrder', Buffer.from([0])), ...(unit === undefined ? [] : [attribute('unit', 'string', Buffer.from(unit))]), Buffer.from([0])]);
  const size = type === 'half' ? 2 : 4;
  const blocks = [];
  for (let first = 0; first < height; first += 16) {
    const lines = Math.min(16, height - first);
    const raw = Buffer.alloc(lines * width * size * names.length);
    let at = 0;
    for (let y = first; y < first + lines; ++y) {
      for (const name of names) {
        for (let x = 0; x < width; ++x, at += size) {
          const value = channels[name](x, y);
          if (type === 'half') raw.writeUInt16LE(toHalf(value), at);
          else if (type === 'uint') raw.writeUInt32LE(value, at);
          else raw.writeFloatLE(value, at);
        }
      }
    }
    const apart = Buffer.alloc(raw.length);
    const half = (raw.length + 1) >> 1;
    for (let i = 0; i < raw.length; ++i) apart[i % 2 === 0 ? i / 2 : half + (i - 1) / 2] = raw[i];
    const packed = Buffer.alloc(raw.length);
    for (let i = 0; i < raw.length; ++i) packed[i] = i === 0 ? apart[0] : (apart[i] - apart[i - 1] + 128) & 255;
    const squeezed = deflateSync(packed, {level: 1});
    blocks.push({first, data: squeezed.length < raw.length ? squeezed : raw});
  }
  let at = header.length + 8 * blocks.length;
  const offsets = Buffer.alloc(8 * blocks.length);
  const parts = blocks.map(({first, data}, i) => {
    offsets.writeBigUInt64LE(BigInt(at), 8 * i);
    at += 8 + data.length;
    return Buffer.concat([number(first), number(data.length), data]);
  });
  return Buffer.concat([header, offsets, ...parts]);
}

// What is made up -----------------------------------------------------------------------------------------------------

/** Where techniques are wrong: row k is k + 1 times 20 of 255 too bright there in red and green, and too dark in blue. */
export const wrong = {x: 40, y: 20, width: 8, height: 8};
const inWrong = (x, y) => x >= wrong.x && y >= wrong.y && x < wrong.x + wrong.width && y < wrong.y + wrong.height;
/** The reference's byte. */
export const reference = (x, y, c, frame) => 70 + ((x * 3 + y * 2 + c * 17 + frame * 5) % 80);
/** A technique's byte. */
export const image = (x, y, c, frame, row) => reference(x, y, c, frame) + (inWrong(x, y) ? (c === 2 ? -1 : 1) * Math.min(20 * (row + 1), 60) : 0);
export const error = (x, y, row) => (inWrong(x, y) ? Math.min(20 * (row + 1), 60) / 255 : 0);
/** Lighting executions; one pixel has more than 16 bits hold. */
export const executions = (x, y, row) => (x === 3 && y === 3 ? 70000 : 1 + (x % 4 === 0 ? row : 0));
const decode = (byte) => (byte / 255 <= 0.04045 ? byte / 255 / 12.92 : ((byte / 255 + 0.055) / 1.055) ** 2.4);
/** Linear radiance: four times the display's white at most. */
export const radiance = (x, y, c, frame, row) => 4 * decode(image(x, y, c, frame, row));

const roles = ['image', 'hdr', 'reference', 'reference_hdr', 'error', 'error_values', 'flip_values', 'shading', 'shading_values'];
const hashOf = (run, row, frame, role) => [run, roles.indexOf(role), role.startsWith('reference') ? 0 : row, frame].map((n) => n.toString(16).padStart(8, '0')).join('');

const techniqueNames = ['noaa', 'msaa', 'msaa', 'streaming', 'streaming', 'dcaa', 'dcaa', 'agaa', 'sbaa', 'visibility', 'dais', 'hybrid'];

export class MadeUpService {
  /** `runs` {id: {frames, rows, width, height, status}} of one capture. */
  constructor(runs) {
    this.runs = runs;
    this.held = null;      // what the API's answers wait for
    this.late = null;      // {after, until}: of the results of a run, all but so many wait for that
    this.broken = new Set(); // roles whose blobs are missing
    this.requests = [];
    this.stories = [];       // what stories were asked for: {technique, x, y, …} as texts
    this.busy = 0;           // so many of them are refused: the service tells another one
    this.missing = false;    // whether there is no such capture
    this.streams = new Set();
    this.files = new Map();
  }

  async start(port = 0) {
    this.server = createServer((request, response) => this.#answer(request, response).catch((failure) => response.destroy(failure)));
    await new Promise((resolve) => this.server.listen(port, '127.0.0.1', resolve));
    this.port = this.server.address().port;
    this.url = `http://127.0.0.1:${this.port}`;
  }

  async stop() {
    for (const stream of this.streams) stream.destroy();
    this.server.closeAllConnections();
    await new Promise((resolve) => this.server.close(resolve));
  }

  /** The API's answers wait until what is returned is called. */
  hold() {
    let release;
    this.held = new Promise((resolve) => (release = resolve)).then(() => (this.held = null));
    return release;
  }

  techniques(run) {
    return Array.from({length: this.runs[run].rows}, (_, row) => ({technique: techniqueNames[row], parameters: {samples: row === 0 ? 1 : 4 * (1 + row % 2)}}));
  }

  result(run, row, frame) {
    const {width, height} = this.runs[run];
    const {technique, parameters} = this.techniques(run)[row];
    const total = 20 + (row === 1 ? 1 : 8 * row) + (frame % 7) * 0.5 + (run > 1 ? 3 : 0);
    return {frame, technique, parameters, samples: parameters.samples, width, height, spread: 1.5,
      ms: {total, cold: 400, passes: {'set-up': 2, geometry: total - 12, shade: 10}, pass_order: ['set-up', 'geometry', 'shade']},
      memory: {paper_bytes_per_pixel: 20 * (row + 1), paper_bytes: 1, fitted_bytes_per_pixel: 16 * (row + 1), fitted_bytes: 1, allocated_bytes: 1e6 * (row + 1)},
      shading: {executions: width * height * (row + 1), per_pixel_mean: row + 1, histogram: [5, 10, 3], fragments: {geometry: 1000}},
      error: {mse: 1e-3 / (row + 1) * (1 + 0.1 * Math.sin(frame / 5)), psnr_db: 30, flip_mean: 0.08 / (row + 1), flip_p99: 0.2, flip_max: 0.5, hdr_rel_mse: 0.1, flicker: frame === 0 ? null : 1e-3 * (1 + frame % 3)},
      counters: {invalid_pixels: 0}, images: Object.fromEntries(roles.map((role) => [role, hashOf(run, row, frame, role)]))};
  }

  run(id) {
    const {frames, rows, width, height, status = 'done', reason = ''} = this.runs[id];
    const expected = frames * rows;
    return {id, status, reason, capture: {hash: 'c'.repeat(32), name: 'made-up.spcap', title: 'Made up'}, created_utc: `2025-01-0${id}T10:00:00Z`, started_utc: `2025-01-0${id}T10:00:00Z`, finished_utc: null,
      request: {capture: 'c'.repeat(32), techniques: this.techniques(id), samples: 4, frames: [0, frames - 1], width: 0, height: 0, repeat: 3, reference_samples: 64, point_lights: 5},
      head: {driver: 'made up', driver_version: '1', device: 'none', cpu_model: 'none', build: 'test', width, height, point_lights: 2, triangles_first_frame: 12, features: ['textures'], wall_s: 10, outside_gpu_s: 4},
      stored_results: status === 'done' ? expected : 0, expected_results: expected, progress: null};
  }

  #blob(hash) {
    const [run, code, row, frame] = [0, 8, 16, 24].map((at) => parseInt(hash.slice(at, at + 8), 16));
    const role = roles[code];
    if (this.broken.has(role) || !this.runs[run]) return null;
    const {width, height} = this.runs[run];
    const bytes = (of) => {
      const rgb = Buffer.alloc(3 * width * height);
      for (let i = 0; i < width * height; ++i) for (let c = 0; c < 3; ++c) rgb[3 * i + c] = of(i % width, Math.floor(i / width), c);
      return png(width, height, rgb);
    };
    const light = (of) => exr(width, height, {R: (x, y) => of(x, y, 0), G: (x, y) => of(x, y, 1), B: (x, y) => of(x, y, 2)}, 'half');
    const make = {
      image: () => bytes((x, y, c) => image(x, y, c, frame, row)), reference: () => bytes((x, y, c) => reference(x, y, c, frame)),
      hdr: () => light((x, y, c) => radiance(x, y, c, frame, row)), reference_hdr: () => light((x, y, c) => 4 * decode(reference(x, y, c, frame))),
      error: () => bytes((x, y) => 255 * error(x, y, row)), error_values: () => exr(width, height, {Y: (x, y) => error(x, y, row)}, 'half', ''),
      flip_values: () => exr(width, height, {Y: (x, y) => error(x, y, row) / 2}, 'float', ''),
      shading: () => bytes((x, y) => executions(x, y, row)), shading_values: () => exr(width, height, {Y: (x, y) => executions(x, y, row)}, 'uint', 'executions'),
    }[role];
    if (!this.files.has(hash)) this.files.set(hash, make());
    return {type: /hdr|values/.test(role) ? 'image/x-exr' : 'image/png', body: this.files.get(hash)};
  }

  async #answer(request, response) {
    const {pathname: path, searchParams} = new URL(request.url, this.url);
    this.requests.push(path);
    response.setHeader('Content-Security-Policy', policy);
    response.setHeader('X-Content-Type-Options', 'nosniff');
    const send = (status, type, body, cache = 'no-store') => {
      response.writeHead(status, {'Content-Type': type, 'Cache-Control': cache, 'Content-Length': Buffer.byteLength(body)});
      response.end(body);
    };
    const json = (document) => send(200, 'application/json', JSON.stringify(document));
    const missing = () => send(404, 'application/json', JSON.stringify({error: {status: 404, what: 'there is no such thing', why: 'none has this name', where: path}}));
    if (!path.startsWith('/api/')) {
      const file = join(web, path === '/' ? 'index.html' : path.slice(1));
      return /^\/[a-z0-9_.-]*$/.test(path) && existsSync(file) ? send(200, media[extname(file)] ?? 'text/plain', readFileSync(file), 'no-cache') : missing();
    }
    if (path !== '/api/health') await this.held;
    const blob = /^\/api\/blobs\/([0-9a-f]{32})$/.exec(path);
    if (blob) {
      const found = this.#blob(blob[1]);
      return found ? send(200, found.type, found.body, 'private, max-age=31536000, immutable') : missing();
    }
    const night = /^\/api\/nights\/(\d+)(?:\/cells\/(\d+))?$/.exec(path);
    if (night) return Number(night[1]) in this.nights ? json(night[2] ? this.nightCell(Number(night[1]), Number(night[2])) : this.night(Number(night[1]))) : missing();
    if (path === `/api/captures/${'c'.repeat(32)}`) return this.missing ? missing() : json({summary: {frames: [{point_lights: 2}]}});
    const one = /^\/api\/runs\/(\d+)(\/.*)?$/.exec(path);
    if (one) return this.runs[one[1]] ? this.#answerRun(Number(one[1]), one[2] ?? '', {json, missing, response}) : missing();
    if (/^\/api\/captures\/c{32}\/pixel$/.test(path)) return this.missing ? missing() : this.#tell(Object.fromEntries(searchParams), {send, json});
    const known = {
      '/api/health': {status: 'ok', version: '0', captures: 1, runs: 2, queued: 0, running: 0, upload_limit_bytes: 1, free_bytes: 1},
      '/api/caller': {token_required: false, name: null, right: 'admin', expires_utc: null, quota_bytes: null, uploaded_bytes: 0},
      '/api/techniques': {techniques: [...new Set(techniqueNames)].map((name) => ({name, title: name, doc: '', parameters: [], maps: []}))},
      '/api/palettes': {palettes: this.palettes}, '/api/limits': {limits: []}, '/api/captures': {captures: [], total: 0},
      '/api/runs': {runs: Object.keys(this.runs).map((id) => this.run(Number(id))).reverse(), next_before: null},
      '/api/nights': {nights: Object.keys(this.nights).map((id) => this.night(Number(id))).reverse(), next_before: null}, '/api/baselines': {baselines: []},
    }[path];
    return known ? json(known) : missing();
  }

  nights = {};  // {number: {lights}}

  /** A night of one capture by three techniques: `msaa` failed, `streaming` is missing. Night n shows what run n has, compared with run 1. */
  night(id) {
    const cell = (at, technique, status) => ({id: 10 * id + at, capture: 'made up', technique, status, gates: [{gate: 'images', outcome: status === 'passed' ? 'passed' : 'failed', detail: `<i>${status}</i>`}]});
    return {id, name: 'nightly', status: 'failed', reason: '', started_utc: `2025-01-0${id}T01:00:00Z`, finished_utc: `2025-01-0${id}T01:10:00Z`, build: 'test', commit: '', baseline: 'nightly', baseline_night: 1, counts: {passed: 1, failed: 1, missing: 1, new: 0},
      captures: [{name: 'made up', source: 'made-up.spcap', hash: 'c'.repeat(32), problem: '', head: {...this.run(1).head, point_lights: this.nights[id].lights}}],
      cells: [cell(0, 'noaa:samples=1', 'passed'), cell(1, 'msaa:samples=8', 'failed'), cell(2, 'streaming:samples=8', 'missing')]};
  }

  nightCell(night, id) {
    const cell = this.night(night).cells.find((candidate) => candidate.id === id);
    const row = id % 10 === 2 ? 3 : id % 10;
    return {...cell, frames: [0, 1].map((frame) => ({frame, baseline: this.result(1, row, frame), tonight: cell.status === 'missing' ? null : this.result(night, row, frame),
      difference: cell.status === 'failed' ? hashOf(1, row, frame, 'error') : null}))};
  }

  #tell(asked, {send, json}) {
    this.stories.push(asked);
    if (this.busy > 0) {
      --this.busy;
      return send(503, 'application/json', JSON.stringify({error: {status: 503, what: 'the story is not told', why: 'another is being told', where: ''}}));
    }
    const [technique, ...parameters] = asked.technique.split(':');
    return json(madeUpStory({technique, parameters: Object.fromEntries(parameters.map((text) => text.split('='))), frame: Number(asked.frame), x: Number(asked.x), y: Number(asked.y)}));
  }

  palettes = {magma: ['#000000', '#800080', '#ffff80'], viridis: ['#000080', '#008080', '#ffff00']};

  /** Of a run's results the first `after` are told at once, the others when what is returned is called. */
  delay(after) {
    let release;
    this.late = {after, until: new Promise((resolve) => (release = resolve))};
    return () => {
      this.late = null;
      release();
    };
  }

  async #answerRun(id, what, {json, missing, response}) {
    const {frames, rows, status = 'done'} = this.runs[id];
    const results = () => Array.from({length: status === 'done' ? frames * rows : 0}, (_, i) => this.result(id, i % rows, Math.floor(i / rows)));
    if (what === '') return json(this.run(id));
    if (what === '/results.json') return json({head: {}, results: results()});
    if (what === '/advice') return json({within: 0, measured: rows, closest: null, choices: []});
    if (what !== '/events') return missing();
    this.streams.add(response);
    response.on('close', () => this.streams.delete(response));
    response.writeHead(200, {'Content-Type': 'text/event-stream', 'Cache-Control': 'no-store'});
    const {reason, stored_results, expected_results, progress} = this.run(id);
    const state = JSON.stringify({status, reason, stored_results, expected_results, progress});
    const texts = results().map((result, i) => `id: ${i + 1}\nevent: result\ndata: ${JSON.stringify({sequence: i + 1, ordinal: i % rows, result})}\n\n`);
    const at = this.late?.after ?? texts.length;
    for (let i = 0; i < at; i += 32) response.write(texts.slice(i, Math.min(i + 32, at)).join(''));
    await this.late?.until;
    for (let i = at; i < texts.length; i += 32) response.write(texts.slice(i, i + 32).join(''));
    response.write(`event: status\ndata: ${state}\n\n`);
    if (status === 'done' || status === 'failed') response.end(`event: end\ndata: ${state}\n\n`);
  }
}
