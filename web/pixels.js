// The page's side of pixels_worker.js, and the coloured pictures that are kept.
const kept = 160 * 2 ** 20;  // bytes

let worker = null;
let ids = 0;
const waiting = new Map();

/** Asks the worker for one of its operations. Rejects with its words. */
export function ask(operation, request) {
  if (!worker) {
    worker = new Worker('/pixels_worker.js', {type: 'module'});
    worker.onmessage = ({data: {id, result, error}}) => {
      const {resolve, reject} = waiting.get(id);
      waiting.delete(id);
      if (error === undefined) resolve(result);
      else reject(new Error(error));
    };
  }
  return new Promise((resolve, reject) => {
    const id = ++ids;
    waiting.set(id, {resolve, reject});
    worker.postMessage({id, operation, request});
  });
}

const bitmaps = new Map();  // key -> {promise of {bitmap, width, height}, bytes}, least recently used first
let held = 0;

/** A coloured picture: of the operation "colour" or "difference". The same request gives the same one while it is kept. */
export function bitmap(operation, request) {
  const key = JSON.stringify([operation, request]);
  const entry = bitmaps.get(key) ?? {promise: null, bytes: 0};
  bitmaps.delete(key);
  bitmaps.set(key, entry);
  entry.promise ??= ask(operation, request).then((picture) => {
    entry.bytes = 4 * picture.width * picture.height;
    held += entry.bytes;
    // One that is still on the screen stays alive by whoever shows it.
    for (const [old, {bytes}] of bitmaps) {
      if (held <= kept || old === key) break;
      bitmaps.delete(old);
      held -= bytes;
    }
    return picture;
  }, (error) => {
    bitmaps.delete(key);
    throw error;
  });
  return entry.promise;
}

/** Bytes of coloured pictures that are kept, for tests. */
export const heldBytes = () => held;
