// One night as a grid, captures by techniques. A cell opens what was judged, and the baseline's image beside tonight's.
import {get, loadPalettes, post, techniques} from './api.js';
import {announce, field, h, replace} from './dom.js';
import {count, fixed, significant, when} from './format.js';
import {setKeys} from './keys.js';
import {NightCell, picture} from './night_cell.js';
import {countsText, nightLength} from './nights_page.js';
import {printed, saveReport} from './report.js';
import {statusPill} from './runs_page.js';
import {ViewAddress} from './view_address.js';
import {viewHints, viewKeys} from './view_input.js';

const marks = {passed: '✓', failed: '✕', missing: '∅', new: '+', unjudged: '·'};

export async function nightPage(id) {
  const [night, {baselines}, registry] = await Promise.all([get(`/api/nights/${id}`), get('/api/baselines'), techniques(), loadPalettes()]);
  const page = new NightPage(night, baselines, registry);
  page.restore();
  return {element: page.element, title: `Night ${id}`, close: () => page.close()};
}

class NightPage {
  #night;
  #baselines;
  #address = new ViewAddress();
  #grid = h('div', {});
  #cell;
  #approval = h('span', {});
  #opened = -1;   // the place of the cell that is open among those of the grid
  #facts;

  constructor(night, baselines, registry) {
    this.#night = night;
    this.#baselines = baselines;
    this.#cell = new NightCell(night, registry, this.#address);
    this.#bindKeys();
    this.#drawApproval();
    this.#drawGrid();
    const machine = night.captures.find((capture) => capture.head)?.head;
    this.#facts = [
      ['started', when(night.started_utc)], ['took', nightLength(night)], ['build', night.build], night.commit && ['commit', night.commit.slice(0, 12)],
      ['compared with', night.baseline_night ? [`${night.baseline}, `, h('a', {href: `#/nights/${night.baseline_night}`}, `night ${night.baseline_night}`)] : `nothing: ${night.baseline} is not approved yet`],
      machine && ['driver', machine.driver_version], machine && ['CPU', machine.cpu_model],
    ].filter(Boolean);
    this.element = h('section.night-page', {},
      h('p.crumbs', {}, h('a', {href: '#/nights'}, 'Nights')),
      h('div.section-head.first', {}, h('h1', {}, `Night ${night.id}`, h('span.quiet', {}, ` ${night.name}`)), h('span.spacer', {}),
        h('button', {type: 'button', onclick: () => this.#address.copy()}, 'Copy address'), h('button', {type: 'button', onclick: () => this.#report()}, 'Report')),
      h('div.progress', {}, statusPill(night.status), h('span', {}, countsText(night.counts)), h('span.spacer', {}), this.#approval,
        night.reason && h('p.problem', {}, night.reason)),
      h('dl.facts.wide', {}, this.#facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value)))),
      h('div.section-head', {}, h('h2', {}, 'Captures by techniques'), h('span.spacer', {}),
        h('a.button', {href: `/api/nights/${night.id}/summary.md`, download: `night-${night.id}.md`}, 'Markdown'),
        h('a.button', {href: `/api/nights/${night.id}/summary.xml`, download: `night-${night.id}.xml`}, 'JUnit'),
        h('a.button', {href: `/api/nights/${night.id}`, download: `night-${night.id}.json`}, 'JSON')),
      this.#grid,
      night.times && h('p.quiet.note', {}, night.times),
      h('p.quiet.note', {}, '✓ as the baseline, ✕ a gate failed, + not in the baseline, ∅ only in the baseline'),
      this.#cell.element, againstSections(night.facts?.against));
  }

  close() {
    this.#address.write();
    this.#cell.close();
    for (const group of ['This night', 'Picture', 'On the picture']) setKeys(group);
  }

  #bindKeys() {
    setKeys('This night', [
      {keys: ['j'], text: 'next cell', act: () => this.#step(1, () => true)},
      {keys: ['k'], text: 'cell before', act: () => this.#step(-1, () => true)},
      {keys: ['a'], text: 'next cell that failed or is missing', act: () => this.#step(1, ({status}) => status === 'failed' || status === 'missing')},
      {keys: ['['], text: 'frame before', act: () => this.#cell.step(-1)},
      {keys: [']'], text: 'next frame', act: () => this.#cell.step(1)},
      {keys: ['A'], text: 'approve this night', act: () => this.#approval.querySelector('button')?.click()},
      {keys: ['r'], text: 'report of what is on the screen', act: () => this.#report()},
      {keys: ['y'], text: 'copy the address of this view', act: () => this.#address.copy()},
    ]);
    setKeys('Picture', viewKeys(this.#cell.view));
    setKeys('On the picture', viewHints);
  }

  /** Opens the cell that the address names. */
  restore() {
    const at = this.#buttons.findIndex(({dataset}) => Number(dataset.cell) === this.#address.number('cell', -1));
    if (at >= 0) this.#show(at, true);
  }

  get #buttons() {
    return [...this.#grid.querySelectorAll('.cell')];
  }

  #cellOf = ({dataset}) => this.#night.cells.find(({id}) => id === Number(dataset.cell));

  // To the next cell of the grid that is wanted, in its order, round its end.
  #step(by, wanted) {
    const buttons = this.#buttons;
    const from = this.#opened < 0 && by < 0 ? 0 : this.#opened;
    for (let i = 1; i <= buttons.length; ++i) {
      const at = (from + by * i + buttons.length * 2) % buttons.length;
      if (wanted(this.#cellOf(buttons[at]))) return this.#show(at);
    }
    announce('There is no such cell');
  }

  #show(at, restored = false) {
    this.#opened = at;
    this.#buttons.forEach((button, i) => button.setAttribute('aria-pressed', String(i === at)));
    this.#cell.open(this.#cellOf(this.#buttons[at]), restored);
  }

  #report() {
    this.#address.write();
    saveReport(`night-${this.#night.id}`, {title: `Night ${this.#night.id} of ${this.#night.name}: ${this.#night.status}`, address: location.href,
      facts: this.#facts.map(([name, value]) => [name, [value].flat().map((part) => part.textContent ?? part).join('')]),
      parts: [{title: 'Captures by techniques', html: printed(this.#grid)}, ...this.#cell.report]});
  }

  #drawApproval() {
    const {id, baseline, status} = this.#night;
    const holder = this.#baselines.find((candidate) => candidate.name === baseline);
    if (status === 'running' || status === 'interrupted') return replace(this.#approval);
    if (holder?.night === id) return replace(this.#approval, h('span.label', {}, `baseline ${baseline}`));
    replace(this.#approval, h('button', {type: 'button', onclick: async () => {
      const why = prompt(`Approve night ${id}? Later nights are then compared with it. Why is it right:`);
      if (why === null) return;
      try {
        await post('/api/baselines', {name: baseline, night: id, why: why.trim()});
        this.#baselines = (await get('/api/baselines')).baselines;
        announce(`Night ${id} is the baseline ${baseline}`);
      } catch (error) {
        announce(error.message);
      }
      this.#drawApproval();
    }}, `Approve as ${baseline}`));
  }

  #drawGrid() {
    const {captures, cells} = this.#night;
    const techniques = [...new Set(cells.map((cell) => cell.technique))];
    const at = new Map(cells.map((cell) => [`${cell.capture}\n${cell.technique}`, cell]));
    replace(this.#grid, h('div.scroll', {}, h('table.grid', {},
      h('thead', {}, h('tr', {}, h('td', {}), techniques.map((technique) => h('th', {scope: 'col'}, h('span', {}, technique))))),
      h('tbody', {}, captures.map((capture) => h('tr', {},
        h('th', {scope: 'row', title: capture.problem || capture.source}, capture.name, capture.problem && h('span.problem', {}, ' !')),
        techniques.map((technique) => {
          const cell = at.get(`${capture.name}\n${technique}`);
          if (!cell) return h('td', {});
          const failed = cell.gates.filter((gate) => gate.outcome === 'failed').map((gate) => gate.gate);
          return h('td', {}, h(`button.cell.${cell.status}`, {
            type: 'button', 'aria-pressed': 'false', 'data-cell': cell.id, 'aria-label': `${capture.name}, ${technique}: ${cell.status}`,
            title: `${capture.name}\n${technique}\n${cell.status}${failed.length > 0 ? `: ${failed.join(', ')}` : ''}`,
            onclick: (event) => this.#show(this.#buttons.indexOf(event.currentTarget)),
          }, marks[cell.status]));
        })))))));
  }
}

// Today's capture of a tag against yesterday's.
function againstSections(against) {
  return Object.entries(against ?? {}).map(([capture, summary]) => h('section.against', {}, h('h2', {}, `${capture}: today against yesterday`),
    summary.problem ? h('p.problem', {}, summary.problem) : summary.same ? h('p.quiet', {}, 'The same is drawn.') : againstBody(summary)));
}

function againstBody(summary) {
  const {draws} = summary;
  const changed = (name) => `${summary[name].changed} ${name}`;
  const both = ({before, now}) => (before === null || now === null ? '–' : `${significant(before, 4)} → ${significant(now, 4)}${before ? `, ${now >= before ? '+' : ''}${fixed(100 * (now / before - 1), 1)}%` : ''}`);
  const titles = {fitted_bytes_per_pixel: 'Bytes per pixel', executions: 'Lighting executions', 'error.mse': 'MSE', 'error.flip_mean': 'FLIP, mean'};
  const techniques = summary.techniques ?? [];
  return [
    h('p', {}, `Draws ${draws.before} → ${draws.after}: ${draws.equal} equal, ${draws.added} added, ${draws.gone} gone, ${draws.changed} changed (${draws.moved} moved); changed: ${['meshes', 'materials', 'textures'].map(changed).join(', ')}.`,
      summary.triangles && ` Triangles ${count(summary.triangles.before)} → ${count(summary.triangles.after)}.`),
    techniques.length > 0 && h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'What was measured of both'}, h('table', {}, h('thead', {}, h('tr', {}, h('th', {scope: 'col'}, 'Technique'), Object.values(titles).map((title) => h('th.number', {scope: 'col'}, title)))),
      h('tbody', {}, techniques.map(({technique, numbers}) => h('tr', {}, h('th', {scope: 'row'}, technique), Object.keys(titles).map((name) => h('td.number', {}, both(numbers[name])))))))),
    dayPictures(techniques),
    summary.list.length > 0 && h('details', {open: summary.list.length <= 12}, h('summary', {}, 'Draws that changed'), h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'Draws that changed'}, h('table', {}, h('thead', {}, h('tr', {}, ['Frame', 'Draw', 'What', 'Details'].map((name) => h('th', {scope: 'col'}, name)))),
      h('tbody', {}, summary.list.map(({frame, draw, what, details}) => h('tr', {}, h('td', {}, frame), h('th', {scope: 'row'}, draw), h('td', {}, what), h('td', {}, details)))))),
      summary.unlisted > 0 && h('p.quiet', {}, `And ${summary.unlisted} more.`)),
  ];
}

function dayPictures(techniques) {
  const shown = techniques.filter(({frames}) => frames.some(({difference}) => difference));
  if (shown.length === 0) return null;
  const pictures = h('div', {});
  const draw = ({frames}) => {
    const frame = frames.find(({difference}) => difference);
    replace(pictures, h('p.quiet.note', {}, `Frame ${frame.frame}`), h('div.pictures', {}, picture('yesterday', frame.yesterday, ''), picture('today', frame.today, ''), picture('difference', frame.difference, '')));
  };
  const choice = h('select', {onchange: () => draw(shown[choice.selectedIndex])}, shown.map(({technique}) => h('option', {}, technique)));
  draw(shown[0]);
  return [h('div.choices', {}, field('Pictures by', choice)), pictures];
}
