// All runs, newest first.
import {get, techniques} from './api.js';
import {h, replace} from './dom.js';
import {techniqueLabel, when} from './format.js';

export function statusPill(status) {
  return h(`span.pill.${status}`, {}, status);
}

export function techniqueLabels(request, registry) {
  return request.techniques.map(({technique, parameters}) =>
    techniqueLabel(technique, parameters, registry.find((entry) => entry.name === technique)));
}

/** The size asked for, else the one the worker reported. */
export function runSize(request, width, height) {
  return request.width > 0 ? `${request.width}×${request.height}` : width ? `${width}×${height}` : 'as recorded';
}

export function runsTable(runs, registry) {
  return h('div.scroll', {}, h('table', {}, h('thead', {}, h('tr', {},
    ['Run', 'Capture', 'Techniques', 'Frames', 'Size', 'Results', 'Status', 'Started'].map((name) => h('th', {scope: 'col'}, name)))),
  h('tbody', {}, runs.map((run) => h('tr', {},
    h('td', {}, h('a', {href: `#/runs/${run.id}`}, `#${run.id}`)),
    h('td', {}, h('a', {href: `#/captures/${run.capture.hash}`}, run.capture.title || run.capture.name)),
    h('td.labels', {}, techniqueLabels(run.request, registry).map((label) => h('span.label', {}, label))),
    h('td', {}, frameRange(run.request.frames)),
    h('td', {}, runSize(run.request, run.head?.width, run.head?.height)),
    h('td.number', {}, `${run.stored_results}/${run.expected_results}`),
    h('td', {}, statusPill(run.status), run.status === 'queued' && h('div.quiet', {}, `priority ${run.priority}`), run.reason && h('div.quiet.clamp', {title: run.reason}, run.reason)),
    h('td', {}, when(run.started_utc ?? run.created_utc)))))));
}

export function frameRange(frames) {
  return frames[0] === frames[1] ? String(frames[0]) : `${frames[0]}–${frames[1]}`;
}

export async function runsPage() {
  const registry = await techniques();
  const body = h('div', {});
  const more = h('button', {type: 'button', onclick: () => load()}, 'Older runs');
  let before = null;
  async function load() {
    const answer = await get(`/api/runs?limit=50${before ? `&before=${before}` : ''}`);
    before = answer.next_before;
    if (answer.runs.length > 0) body.append(runsTable(answer.runs, registry));
    else if (!body.hasChildNodes()) replace(body, h('p.quiet', {}, 'None yet. Choose a capture and start one.'));
    more.hidden = !before;
  }
  await load();
  return {title: 'Runs', element: h('section', {}, h('h1', {}, 'Runs'), body, more)};
}
