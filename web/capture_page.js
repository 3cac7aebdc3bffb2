// One capture: what it is, its runs, and the form that starts a new one.
import {get, limits, post, remove, techniques} from './api.js';
import {featureTags, thumbnail} from './captures_page.js';
import {announce, field, h} from './dom.js';
import {bytes, count, when} from './format.js';
import {runForm} from './run_form.js';
import {runsTable} from './runs_page.js';

// What whoever recorded, imported, cut or read the capture left out or approximated.
function noticeList(notices) {
  if (notices.length === 0) return [];
  return [h('h2', {}, 'Notices'), h('ul.notices', {}, notices.map((notice) => h('li', {}, notice)))];
}

export async function capturePage(hash) {
  const [capture, registry, limitTable, {runs}] = await Promise.all([
    get(`/api/captures/${hash}`), techniques(), limits(), get(`/api/runs?capture=${hash}&limit=50`),
  ]);
  const title = capture.title || capture.name;
  const deletion = h('button.danger', {type: 'button', onclick: async () => {
    if (!confirm(`Delete "${title}" with all of its runs?`)) return;
    try {
      await remove(`/api/captures/${hash}`);
      location.hash = '#/';
    } catch (error) {
      problem.textContent = error.message;
    }
  }}, 'Delete');
  const problem = h('p.problem', {role: 'alert'});
  const tags = h('input', {type: 'text', value: capture.tags.join(', '), 'aria-label': 'Tags'});
  const tagForm = h('form.tag-form', {onsubmit: async (event) => {
    event.preventDefault();
    problem.textContent = '';
    try {
      const stored = await post(`/api/captures/${hash}/tags`, {tags: tags.value.split(',').map((tag) => tag.trim()).filter(Boolean)});
      tags.value = stored.tags.join(', ');
      announce('The tags are stored');
    } catch (error) {
      problem.textContent = error.message;
    }
  }}, field('Tags', tags, 'separated by commas; nights replay captures by their tag'), h('button', {type: 'submit'}, 'Set tags'));
  const facts = [
    ['file', capture.name], ['frames', count(capture.frame_count)], ['triangles, fullest frame', count(capture.triangles)],
    ['recorded at', `${capture.width}×${capture.height}`], ['size', bytes(capture.size_bytes)],
    ['uploaded', when(capture.uploaded_utc)], ['content hash', capture.hash],
  ];
  const element = h('section', {},
    h('p.crumbs', {}, h('a', {href: '#/'}, 'Captures')),
    h('h1', {}, title),
    h('div.capture-head', {}, thumbnail(capture),
      h('div', {}, h('dl.facts.wide', {}, facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value)))),
        featureTags(capture.features), tagForm,
        h('p.actions', {}, h('a.button', {href: `/api/captures/${hash}/file`, download: capture.name}, 'Download'), deletion),
        problem)),
    noticeList(capture.summary.notices ?? []),
    h('h2', {}, 'New run'),
    capture.frame_count > 0 ? runForm(capture, registry, limitTable) : h('p', {}, 'This capture has no frames.'),
    h('h2', {}, 'Runs'),
    runs.length > 0 ? runsTable(runs, registry) : h('p.quiet', {}, 'None yet.'));
  return {title, element};
}
