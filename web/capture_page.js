// One capture: what it is, its runs, and the form that starts a new one.
import {get, limits, post, remove, techniques} from './api.js';
import {featureTags, thumbnail} from './captures_page.js';
import {announce, field, h} from './dom.js';
import {FilmStrip} from './film_strip.js';
import {bytes, count, when} from './format.js';
import {FrameView} from './frame_view.js';
import {setKeys} from './keys.js';
import {printed, saveReport} from './report.js';
import {runForm} from './run_form.js';
import {runsTable} from './runs_page.js';
import {ViewAddress} from './view_address.js';

// What whoever recorded, imported, cut or read the capture left out or approximated.
function noticeList(notices) {
  if (notices.length === 0) return [];
  return [h('h2', {}, 'Notices'), h('p.quiet', {}, 'What recording, importing, trimming or reading left out or changed, and why.'),
    h('ul.notices', {}, notices.map((notice) => h('li', {}, notice)))];
}

// What each of a summary's features means for techniques and reference.
const needs = {
  'textures': 'materials read images: texture coordinates are interpolated, and images filtered, for each shading',
  'alpha test': 'textures cut holes into triangles: coverage is known only after they are read',
  'normal maps': 'normals come from images: neighbouring shadings of one surface may differ',
  'emissive': 'materials shine by themselves, brighter than white: what the resolve makes of it shows at edges',
  'metal': 'materials reflect like metal: highlights alias, the more the smoother they are',
  'two-sided': 'back faces are seen: they are kept, with their normal turned round',
  'blending': 'materials are translucent: samples are covered by chance, as many as their opacity says',
  'instancing': 'draws repeat a mesh under several matrices',
  'shadows': 'the sun casts shadows: a shadow map is drawn before the frame',
  'spot lights': 'lights shine in cones',
  'vertex colours': 'vertices carry colours, which are interpolated for each shading',
  'second UV set': 'textures are read by a second set of coordinates',
  'texture transforms': 'texture coordinates are moved, turned or scaled before images are read',
  'samplers': 'images are read with wrapping or filters of their own',
  'unlit': 'materials are shown as they are, without light',
};

// `reasons`: which materials, draws or frames need each; captures stored before there were any have none.
function needList(features, reasons = {}) {
  if (features.length === 0) return [];
  return [h('h2', {}, 'What the scene needs'), h('dl.needs', {}, features.map((feature) => h('div', {}, h('dt', {}, feature), h('dd', {}, needs[feature] ?? '', reasons[feature] && h('div.quiet', {}, `because of ${reasons[feature]}`)))))];
}

// Frames and draws are asked for when they are opened: the service replays the frame for them. What is open is in the address.
function framesPanel(capture) {
  const {hash, frame_count: frames, width, height} = capture;
  const side = 640;
  const scale = side / Math.max(width, height, 1);
  const size = [width, height].map((length) => Math.max(1, Math.round(length * scale) || 1));
  const address = new ViewAddress();
  const wanted = Math.trunc(address.number('frame', 0));
  let shown = {frame: wanted >= 0 && wanted < frames ? wanted : 0, draw: address.number('draw', null), material: address.number('material', null)};
  const tell = (choice) => {
    shown = {...shown, ...choice};
    address.set(shown);
  };
  const view = new FrameView(hash, size, (choice) => panel.open && tell(choice));
  const strip = new FilmStrip(hash, frames, (frame) => show(frame));
  const number = h('input', {type: 'number', min: 0, max: frames - 1, value: 0, onchange: () => number.reportValidity() && show(number.valueAsNumber)});
  const show = (frame, choice = {draw: null, material: null}) => {
    number.value = frame;
    strip.select(frame);
    tell({frame, ...choice});
    return view.show(frame, choice);
  };
  const panel = h('details.frames-panel', {open: address.text('frame') !== '', ontoggle: async () => {
    if (!panel.open) return address.set({frame: null, draw: null, material: null});
    if (view.element.hasChildNodes()) return tell({});
    await show(shown.frame, shown);
    if (frames > 1) strip.fill();
  }}, h('summary', {}, 'Frames and draws'), frames > 1 && [strip.element, field('Frame', number)], view.element);
  const step = (by) => panel.open && shown.frame + by >= 0 && shown.frame + by < frames && show(shown.frame + by);
  setKeys('This capture', [
    {keys: ['d'], text: 'frames and draws, or not', act: () => (panel.open = !panel.open)},
    {keys: ['['], text: 'frame before', act: () => step(-1)},
    {keys: [']'], text: 'next frame', act: () => step(1)},
    {keys: ['j'], text: 'next draw', act: () => panel.open && view.step(1)},
    {keys: ['k'], text: 'draw before', act: () => panel.open && view.step(-1)},
    {keys: ['0'], text: 'no draw', act: () => panel.open && view.step(0)},
    {keys: ['y'], text: 'copy the address of this view', act: () => address.copy()},
  ]);
  return {element: panel, address, close: () => {
    address.write();
    strip.close();
    setKeys('This capture');
  }};
}

const reportTitles = {needs: 'What the scene needs', notices: 'Notices', runs: 'Runs'};

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
  const frames = capture.frame_count > 0 ? framesPanel(capture) : null;
  const element = h('section', {},
    h('p.crumbs', {}, h('a', {href: '#/'}, 'Captures')),
    h('div.section-head.first', {}, h('h1', {}, title), h('span.spacer', {}),
      frames && h('button', {type: 'button', onclick: () => frames.address.copy()}, 'Copy address'), h('button', {type: 'button', onclick: () => report()}, 'Report')),
    h('div.capture-head', {}, thumbnail(capture),
      h('div', {}, h('dl.facts.wide', {}, facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value)))),
        featureTags(capture.features), tagForm,
        h('p.actions', {}, h('a.button', {href: `/api/captures/${hash}/file`, download: capture.name}, 'Download'), deletion),
        problem)),
    frames?.element, needList(capture.features, capture.summary.feature_reasons), noticeList(capture.summary.notices ?? []),
    h('h2', {}, 'New run'),
    capture.frame_count > 0 ? runForm(capture, registry, limitTable) : h('p', {}, 'This capture has no frames.'),
    h('h2', {}, 'Runs'),
    runs.length > 0 ? h('div.runs', {}, runsTable(runs, registry)) : h('p.quiet', {}, 'None yet.'));
  const report = () => {
    frames?.address.write();
    saveReport(`capture-${hash.slice(0, 8)}`, {title, address: location.href, facts, parts: [...element.querySelectorAll('.capture-head > .thumbnail, .frames-panel[open] .frame-view, .needs, .notices, .runs')].map((part) => ({title: reportTitles[part.classList[0]], html: printed(part)}))});
  };
  setKeys('Report', [{keys: ['r'], text: 'report of what is on the screen', act: report}]);
  return {title, element, close: () => {
    frames?.close();
    setKeys('Report');
  }};
}
