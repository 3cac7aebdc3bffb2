// One night as a grid, captures by techniques. A cell opens what was judged, and the baseline's image beside tonight's.
import {blobUrl, get, loadPalettes, post, techniques} from './api.js';
import {CompareView} from './compare_view.js';
import {legend} from './colour_scales.js';
import {announce, field, h, replace} from './dom.js';
import {bytes, count, fixed, scientific, significant, when} from './format.js';
import {setKeys} from './keys.js';
import {layerOf} from './run_layers.js';
import {countsText, nightLength} from './nights_page.js';
import {statusPill} from './runs_page.js';
import {trendAddress} from './trends_page.js';
import {viewHints, viewKeys} from './view_input.js';

const marks = {passed: '✓', failed: '✕', missing: '∅', new: '+', unjudged: '·'};
const differenceScale = {map: 'magma', maximum: 0.25, description: 'largest absolute difference of the sRGB channels to the baseline', unit: ''};

export async function nightPage(id) {
  const [night, {baselines}, registry] = await Promise.all([get(`/api/nights/${id}`), get('/api/baselines'), techniques(), loadPalettes()]);
  const page = new NightPage(night, baselines, registry);
  return {element: page.element, title: `Night ${id}`, close: () => page.close()};
}

class NightPage {
  #night;
  #baselines;
  #view = new CompareView();
  #registry;
  #grid = h('div', {});
  #cell = h('section.night-cell', {'aria-live': 'polite'});
  #approval = h('span', {});
  #open = null;

  constructor(night, baselines, registry) {
    this.#registry = registry;
    setKeys('Picture', viewKeys(this.#view));
    setKeys('On the picture', viewHints);
    this.#night = night;
    this.#baselines = baselines;
    this.#drawApproval();
    this.#drawGrid();
    const machine = night.captures.find((capture) => capture.head)?.head;
    const facts = [
      ['started', when(night.started_utc)], ['took', nightLength(night)], ['build', night.build], night.commit && ['commit', night.commit.slice(0, 12)],
      ['compared with', night.baseline_night ? [`${night.baseline}, `, h('a', {href: `#/nights/${night.baseline_night}`}, `night ${night.baseline_night}`)] : `nothing: ${night.baseline} is not approved yet`],
      machine && ['driver', machine.driver_version], machine && ['CPU', machine.cpu_model],
    ].filter(Boolean);
    this.element = h('section.night-page', {},
      h('p.crumbs', {}, h('a', {href: '#/nights'}, 'Nights')),
      h('h1', {}, `Night ${night.id}`, h('span.quiet', {}, ` ${night.name}`)),
      h('div.progress', {}, statusPill(night.status), h('span', {}, countsText(night.counts)), h('span.spacer', {}), this.#approval,
        night.reason && h('p.problem', {}, night.reason)),
      h('dl.facts.wide', {}, facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value)))),
      h('div.section-head', {}, h('h2', {}, 'Captures by techniques'), h('span.spacer', {}),
        h('a.button', {href: `/api/nights/${night.id}/summary.md`, download: `night-${night.id}.md`}, 'Markdown'),
        h('a.button', {href: `/api/nights/${night.id}/summary.xml`, download: `night-${night.id}.xml`}, 'JUnit'),
        h('a.button', {href: `/api/nights/${night.id}`, download: `night-${night.id}.json`}, 'JSON')),
      this.#grid,
      night.times && h('p.quiet.note', {}, night.times),
      h('p.quiet.note', {}, '✓ as the baseline, ✕ a gate failed, + not in the baseline, ∅ only in the baseline'),
      this.#cell, againstSections(night.facts?.against));
  }

  close() {
    this.#view.close();
    setKeys('Picture');
    setKeys('On the picture');
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
            type: 'button', 'aria-pressed': 'false', 'aria-label': `${capture.name}, ${technique}: ${cell.status}`,
            title: `${capture.name}\n${technique}\n${cell.status}${failed.length > 0 ? `: ${failed.join(', ')}` : ''}`,
            onclick: (event) => this.#show(cell, event.currentTarget),
          }, marks[cell.status]));
        })))))));
  }

  async #show(cell, button) {
    this.#grid.querySelectorAll('.cell[aria-pressed="true"]').forEach((other) => other.setAttribute('aria-pressed', 'false'));
    button.setAttribute('aria-pressed', 'true');
    this.#open = cell.id;
    let details;
    try {
      details = await get(`/api/nights/${this.#night.id}/cells/${cell.id}`);
    } catch (error) {
      return replace(this.#cell, h('p.problem', {role: 'alert'}, error.message));
    }
    if (this.#open !== cell.id) return;  // another cell was opened meanwhile
    const frames = h('select', {onchange: () => draw(details.frames[Number(frames.value)])},
      details.frames.map((frame, i) => h('option', {value: i}, `${frame.frame}${frame.difference ? ', differs' : ''}`)));
    const pictures = h('div.pictures', {});
    const figures = h('div', {});
    const scale = h('div', {});
    let other = null;  // the same cell of another night: {night, frames}
    const nights = h('select', {onchange: async () => {
      try {
        other = nights.value ? await this.#cellOf(Number(nights.value), details) : null;
        if (nights.value && !other) announce(`Night ${nights.value} does not have this cell`);
      } catch (error) {
        announce(error.message);
      }
      draw(details.frames[Number(frames.value)]);
    }}, h('option', {value: ''}, 'no other night'));
    this.#listNights(nights);
    const draw = (frame) => {
      replace(pictures, picture('baseline', frame?.baseline?.images.image, 'The baseline does not have it.'),
        picture('tonight', frame?.tonight?.images.image, 'It was not replayed.'),
        picture('difference', frame?.difference, frame?.tonight && frame?.baseline ? 'The images are equal.' : 'There is nothing to compare.'));
      replace(scale, frame?.difference && legend(differenceScale));
      replace(figures, frame && figuresTable(frame.baseline, frame.tonight));
      const layers = this.#layersOf(frame, other);
      this.#view.element.hidden = layers.length === 0;
      if (layers.length > 0) this.#view.setLayers(layers);
    };
    replace(this.#cell,
      h('div.section-head', {}, h('h2', {}, `${details.capture}, ${details.technique}`), statusPill(details.status),
        details.frames.length > 1 && field('frame', frames), field('and of', nights),
        h('span.spacer', {}), h('a.button', {href: trendAddress(this.#night.name, details.capture, details.technique)}, 'Trend')),
      gatesTable(details.gates), pictures, scale, figures, this.#view.element);
    // The first frame that differs says most.
    const first = Math.max(0, details.frames.findIndex((frame) => frame.difference));
    frames.value = first;
    draw(details.frames[first]);
    this.#cell.scrollIntoView({block: 'nearest'});
  }

  async #listNights(select) {
    try {
      const {nights} = await get(`/api/nights?name=${encodeURIComponent(this.#night.name)}&limit=50`);
      for (const {id, started_utc: started} of nights) if (id !== this.#night.id) select.append(h('option', {value: id}, `night ${id}, ${when(started)}`));
    } catch {
      // Then there is none to choose.
    }
  }

  async #cellOf(night, {capture, technique}) {
    const {cells} = await get(`/api/nights/${night}`);
    const cell = cells.find((candidate) => candidate.capture === capture && candidate.technique === technique);
    return cell ? {night, frames: (await get(`/api/nights/${night}/cells/${cell.id}`)).frames} : null;
  }

  // Baseline and tonight, their error maps, and the image of another night.
  #layersOf(frame, other) {
    const layers = [];
    const add = (result, label, roles) => {
      if (!result) return;
      const row = {label, entry: this.#registry.find(({name}) => name === result.technique)};
      for (const role of roles) layers.push(layerOf(`${label}:${role}`, row, result, role));
    };
    add(frame?.baseline, 'baseline', ['image']);
    add(frame?.tonight, 'tonight', ['image']);
    add(other?.frames.find((candidate) => candidate.frame === frame?.frame)?.tonight, `night ${other?.night}`, ['image']);
    add(frame?.baseline, 'baseline', ['error']);
    add(frame?.tonight, 'tonight', ['error', 'shading']);
    return layers.filter(Boolean);
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

function picture(title, blob, absent) {
  return h('figure', {}, h('figcaption', {}, title),
    blob ? h('a', {href: blobUrl(blob)}, h('img', {src: blobUrl(blob), alt: title})) : h('div.none', {}, absent));
}

function gatesTable(gates) {
  return h('div.scroll', {}, h('table.gates', {}, h('thead', {}, h('tr', {}, ['Gate', 'Outcome', 'Why'].map((name) => h('th', {scope: 'col'}, name)))),
    h('tbody', {}, gates.map((gate) => h('tr', {},
      h('th', {scope: 'row'}, gate.gate), h('td', {}, statusPill(gate.outcome)), h('td', {}, gate.detail))))));
}

const figures = [
  ['published bytes per pixel', (r) => significant(r.memory.paper_bytes_per_pixel, 5)],
  ['fitted bytes per pixel', (r) => significant(r.memory.fitted_bytes_per_pixel, 5)],
  ['allocated', (r) => bytes(r.memory.allocated_bytes)],
  ['lighting executions', (r) => count(r.shading.executions)],
  ['ms', (r) => fixed(r.ms.total, 2)],
  ['MSE', (r) => scientific(r.error.mse ?? NaN)],
  ['FLIP, mean', (r) => fixed(r.error.flip_mean ?? NaN, 5)],
];

function figuresTable(before, now) {
  const counters = [...new Set([before, now].flatMap((result) => Object.keys(result?.counters ?? {})))];
  const rows = [...figures, ...counters.map((name) => [name, (r) => count(r.counters[name])])].map(([name, text]) =>
    [name, before ? text(before) : '–', now ? text(now) : '–']);
  return h('details', {}, h('summary', {}, 'Figures of this frame'), h('div.scroll', {}, h('table', {}, h('thead', {}, h('tr', {},
    h('th', {scope: 'col'}, ''), h('th.number', {scope: 'col'}, 'Baseline'), h('th.number', {scope: 'col'}, 'Tonight'))),
  h('tbody', {}, rows.map(([name, a, b]) => h('tr', {class: a === b ? '' : 'differs'},
    h('th', {scope: 'row'}, name), h('td.number', {}, a), h('td.number', {}, b)))))));
}
