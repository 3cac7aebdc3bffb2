// All captures, and the upload of new ones.
import {blobUrl, get, uploadCapture} from './api.js';
import {announce, h, replace} from './dom.js';
import {bytes, count, shortCount, when} from './format.js';

export function thumbnail(capture) {
  return capture.thumbnail
    ? h('img.thumbnail', {src: blobUrl(capture.thumbnail), alt: '', width: 320, height: 180, loading: 'lazy'})
    : h('div.thumbnail.none', {}, 'no picture yet');
}

export function featureTags(features) {
  return h('ul.tags', {'aria-label': 'What the scene needs'}, features.map((feature) => h('li', {}, feature)));
}

function captureCard(capture) {
  return h('li.card', {},
    h('a.cover', {href: `#/captures/${capture.hash}`}, thumbnail(capture), h('span.name', {}, capture.title || capture.name)),
    h('div.card-text', {},
      h('div.quiet.ellipsis', {title: capture.name}, capture.name),
      h('dl.facts', {},
        fact('frames', count(capture.frame_count)), fact('triangles', shortCount(capture.triangles)),
        fact('recorded at', `${capture.width}×${capture.height}`), fact('size', bytes(capture.size_bytes))),
      featureTags(capture.features),
      h('div.quiet', {}, when(capture.uploaded_utc))));
}

function fact(name, value) {
  return h('div', {}, h('dt', {}, name), h('dd', {}, value));
}

// One line for each upload: its bar, then its outcome.
function uploadLine(file, onStored) {
  const bar = h('progress', {max: 100, value: 0, 'aria-label': `Upload of ${file.name}`});
  const state = h('span.quiet', {}, 'sending');
  const cancel = h('button.plain', {type: 'button', onclick: () => upload.abort()}, 'Cancel');
  const line = h('li.upload', {}, h('span.ellipsis', {}, file.name), bar, state, cancel);
  const upload = uploadCapture(file, (sent, total) => {
    bar.value = total > 0 ? (100 * sent) / total : 100;
    state.textContent = sent < total ? `${bytes(sent)} of ${bytes(total)}` : 'being checked';
  });
  upload.promise.then(({capture, added}) => {
    replace(line, h('span.ellipsis', {}, file.name),
      h('a', {href: `#/captures/${capture.hash}`}, added ? 'stored' : 'was here already'),
      capture.notices.length > 0 && h('ul.notices', {'aria-label': `Notices of ${file.name}`}, capture.notices.map((notice) => h('li', {}, notice))));
    announce(`${file.name} ${added ? 'is stored' : 'was here already'}`);
    onStored();
  }, (error) => {
    replace(line, h('span.ellipsis', {}, file.name), h('span.problem', {role: 'alert'}, error.message));
  });
  return line;
}

export async function capturesPage() {
  const list = h('ul.cards', {});
  const uploads = h('ul.uploads', {});
  let closed = false;
  let timer = 0;

  async function refresh() {
    clearTimeout(timer);
    const {captures, total} = await get('/api/captures?limit=200');
    if (closed) return;
    replace(list, captures.length > 0 ? captures.map(captureCard) : h('li.empty', {}, 'No captures yet. Drop one above.'));
    heading.textContent = total > 0 ? `Captures (${count(total)})` : 'Captures';
    // A thumbnail is rendered after its upload; look again while one is to come.
    const awaited = captures.some((c) => !c.thumbnail && Date.now() - Date.parse(c.uploaded_utc) < 120_000);
    if (awaited) timer = setTimeout(() => refresh().catch(() => {}), 1500);
  }

  function take(files) {
    for (const file of files) uploads.append(uploadLine(file, () => refresh().catch(() => {})));
  }

  const input = h('input.visually-hidden', {type: 'file', multiple: true, id: 'file', onchange: () => {
    take(input.files);
    input.value = '';
  }});
  const zone = h('div.drop', {
    ondragover: (event) => {
      event.preventDefault();
      zone.classList.add('over');
    },
    ondragleave: () => zone.classList.remove('over'),
    ondrop: (event) => {
      event.preventDefault();
      zone.classList.remove('over');
      take(event.dataTransfer.files);
    },
  }, input, h('label', {for: 'file'}, h('strong', {}, 'Drop captures here'), ' or ', h('span.link', {}, 'choose files')),
  h('small', {}, '.spcap, as `subpixel import` and `subpixel generate` write them; imported here: .glb, .zip of a glTF or OBJ ' +
    'with its textures, .rdc of RenderDoc'));

  const heading = h('h1', {}, 'Captures');
  await refresh();
  return {
    title: 'Captures',
    element: h('section', {}, heading, zone, uploads, list),
    close: () => {
      closed = true;
      clearTimeout(timer);
    },
  };
}
