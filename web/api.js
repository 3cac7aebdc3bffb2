// The service's API (docs/http_api.md).

export class ApiError extends Error {
  constructor({status = 0, what = 'The request failed', why = '', where = ''}) {
    super([what, why, where].filter(Boolean).join(': '));
    Object.assign(this, {status, what, why, where});
  }
}

async function answer(response) {
  const text = await response.text();
  let document = null;
  try {
    document = text ? JSON.parse(text) : null;
  } catch {
    // Reported below: a success without a document is as useless as a failure.
  }
  if (response.ok) return document;
  throw new ApiError(document?.error ?? {status: response.status, why: `status ${response.status}`});
}

async function request(method, path, body) {
  let response;
  try {
    response = await fetch(path, {
      method,
      headers: body === undefined ? {} : {'Content-Type': 'application/json'},
      // The service wants to know every body's length, also of an empty one.
      body: body === undefined ? (method === 'POST' ? '' : undefined) : JSON.stringify(body),
    });
  } catch {
    throw new ApiError({what: 'The service does not answer', why: 'is it running?'});
  }
  return answer(response);
}

export const get = (path) => request('GET', path);
export const post = (path, body) => request('POST', path, body);
export const remove = (path) => request('DELETE', path);

const patience = 700;  // ms until the service is asked again that makes something for someone else

let last = Promise.resolve();

/**
 * What the service makes one at a time, stories and pictures of frames: asked for one after the other, and again while it makes another's.
 * Null when `wanted()` says meanwhile that it is not wanted any more.
 */
export function getInTurn(path, wanted = () => true) {
  const answered = async () => {
    while (wanted()) {
      try {
        return await get(path);
      } catch (error) {
        if (error.status !== 503) throw error;
      }
      await new Promise((resolve) => setTimeout(resolve, patience));
    }
    return null;
  };
  const mine = last.then(answered);
  last = mine.catch(() => {});
  return mine;
}

let registry = null;
/** The techniques, fetched once. */
export async function techniques() {
  registry ??= (await get('/api/techniques')).techniques;
  return registry;
}

let limitTable = null;
/** What a run can be asked for, by name: {low, high, multiple_of, values, unit, meaning}. Fetched once. */
export async function limits() {
  limitTable ??= Object.fromEntries((await get('/api/limits')).limits.map((limit) => [limit.name, limit]));
  return limitTable;
}

let palettes = null;
/** Fetches the colour maps, once. */
export async function loadPalettes() {
  palettes ??= (await get('/api/palettes')).palettes;
}
/** Evenly spaced colours of a map ("#rrggbb"), linear between them; loadPalettes() comes before. */
export const palette = (map) => palettes[map];

export const blobUrl = (hash) => `/api/blobs/${hash}`;

/**
 * Sends a file. `onProgress(sentBytes, totalBytes)`. Returns {promise, abort}. XMLHttpRequest, because fetch does not tell
 * how much of a body is sent.
 */
export function uploadCapture(file, onProgress) {
  const xhr = new XMLHttpRequest();
  const promise = new Promise((resolve, reject) => {
    xhr.open('POST', `/api/captures?name=${encodeURIComponent(file.name)}`);
    xhr.setRequestHeader('Content-Type', 'application/octet-stream');
    xhr.upload.addEventListener('progress', (event) => onProgress(event.loaded, file.size));
    xhr.addEventListener('load', () => {
      let document = {};
      try {
        document = JSON.parse(xhr.responseText);
      } catch {
        // Falls through to an error that names the status.
      }
      if (xhr.status >= 200 && xhr.status < 300) resolve({capture: document, added: xhr.status === 201});
      else reject(new ApiError(document.error ?? {status: xhr.status, why: `status ${xhr.status}`}));
    });
    xhr.addEventListener('error', () => reject(new ApiError({what: 'The upload broke off', why: 'the connection was lost'})));
    xhr.addEventListener('abort', () => reject(new ApiError({what: 'The upload was cancelled'})));
    xhr.send(file);
  });
  return {promise, abort: () => xhr.abort()};
}

/**
 * Follows a run until its end. `on.result({sequence, ordinal, result})`, `on.status(status)`, `on.end(status)`, `on.lost()`.
 * Returns a function that stops following.
 */
export function followRun(id, on) {
  const source = new EventSource(`/api/runs/${id}/events`);
  source.addEventListener('result', (event) => on.result(JSON.parse(event.data)));
  source.addEventListener('status', (event) => on.status(JSON.parse(event.data)));
  source.addEventListener('end', (event) => {
    source.close();
    on.end(JSON.parse(event.data));
  });
  // The browser reconnects by itself and asks for what it missed by the last event's id.
  source.addEventListener('error', () => on.lost());
  return () => source.close();
}
