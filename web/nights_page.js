// All nights, newest first, with how they ended.
import {get} from './api.js';
import {h, replace} from './dom.js';
import {duration, when} from './format.js';
import {statusPill} from './runs_page.js';

export const nightLength = (night) => (night.finished_utc ? duration((Date.parse(night.finished_utc) - Date.parse(night.started_utc)) / 1000) : '');

/** "2 failed, 38 passed": the counts that are not 0, the worst first. */
export function countsText(counts) {
  return ['failed', 'missing', 'new', 'passed'].filter((name) => counts[name] > 0).map((name) => `${counts[name]} ${name}`).join(', ') || 'no cells';
}

function nightsTable(nights, approved) {
  return h('div.scroll', {}, h('table.nights', {}, h('thead', {}, h('tr', {},
    ['Night', 'Configuration', 'Verdict', 'Cells', 'Compared with', 'Started', 'Took'].map((name) => h('th', {scope: 'col'}, name)))),
  h('tbody', {}, nights.map((night) => h('tr', {},
    h('td', {}, h('a', {href: `#/nights/${night.id}`}, `#${night.id}`),
      approved.filter((baseline) => baseline.night === night.id).map((baseline) => h('span.label', {}, `baseline ${baseline.name}`))),
    h('td', {}, night.name, ' ', h('a.quiet', {href: `#/trends?${new URLSearchParams({name: night.name})}`, 'aria-label': `Trends of ${night.name}`}, 'trends')),
    h('td', {}, statusPill(night.status)),
    h('td', {}, countsText(night.counts)),
    h('td', {}, night.baseline_night ? [`${night.baseline} `, h('a', {href: `#/nights/${night.baseline_night}`}, `#${night.baseline_night}`)] : h('span.quiet', {}, 'nothing')),
    h('td', {}, when(night.started_utc)),
    h('td', {}, nightLength(night)))))));
}

export async function nightsPage() {
  const {baselines} = await get('/api/baselines');
  const body = h('div', {});
  const more = h('button', {type: 'button', onclick: () => load()}, 'Older nights');
  let before = null;
  async function load() {
    const answer = await get(`/api/nights?limit=50${before ? `&before=${before}` : ''}`);
    before = answer.next_before;
    if (answer.nights.length > 0) body.append(nightsTable(answer.nights, baselines));
    else if (!body.hasChildNodes()) replace(body, h('p.quiet', {}, 'None yet. `subpixel nightly --config FILE --data FOLDER` runs one over this data folder.'));
    more.hidden = !before;
  }
  await load();
  return {title: 'Nights', element: h('section', {}, h('h1', {}, 'Nights'), body, more)};
}
