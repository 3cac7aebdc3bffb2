// A cell's numbers over nights, a plot for each (uPlot): what the gates allowed, which nights were approved, where the
// build changed, and where a number moved.
import {get} from './api.js';
import {announce, h, replace} from './dom.js';
import {significant, when} from './format.js';
import {setKeys} from './keys.js';
import {loadPlots} from './over_frames.js';
import {printed, saveReport} from './report.js';
import {tickText} from './svg.js';

const plotHeight = 190;
const titles = {
  'error.mse': 'MSE', 'error.flip_mean': 'FLIP, mean', 'error.flip_p99': 'FLIP, 99th percentile', 'error.flip_max': 'FLIP, maximum',
  'error.hdr_rel_mse': 'relative MSE of the linear image', 'error.flicker': 'flicker', executions: 'lighting executions',
  paper_bytes_per_pixel: 'published bytes per pixel', fitted_bytes_per_pixel: 'fitted bytes per pixel', allocated_bytes: 'allocated bytes',
  ms: 'ms, which only mean something on one machine', instructions: 'instructions',
};
const titleOf = (number) => titles[number] ?? (number.startsWith('time.') ? `time over that of ${number.slice(5)}` : number.replace(/^counters\./, 'counter '));
// Errors and times first: what people look for.
const order = (number) => ['error.', 'time.', 'executions', 'fitted', 'paper', 'allocated', 'ms', 'instructions', 'counters.'].findIndex((start) => number.startsWith(start));
const commitText = (commit) => commit.slice(0, 12) || 'no commit';

export const trendAddress = (name, capture, technique) => `#/trends?${new URLSearchParams({name, capture, technique})}`;

export async function trendsPage() {
  const page = new TrendsPage(new URLSearchParams(location.hash.split('?')[1] ?? ''));
  await page.load();
  return {element: page.element, title: 'Trends', close: () => page.close()};
}

class TrendsPage {
  #name;
  #cells = [];      // [{capture, technique}]
  #cell;
  #body = h('div', {});
  #choice = h('select', {'aria-label': 'Cell', onchange: () => this.#open(this.#choice.selectedIndex)});
  #head = h('h1', {});
  #csv = h('a.button', {}, 'CSV');
  #csvAll = h('a.button', {}, 'CSV of all cells');
  #plots = [];
  #turn = 0;
  #resize = new ResizeObserver(() => this.#plots.forEach(({plot, place}) => plot.setSize({width: place.clientWidth, height: plotHeight})));

  constructor(query) {
    this.#name = query.get('name') ?? '';
    this.#cell = {capture: query.get('capture') ?? '', technique: query.get('technique') ?? ''};
    this.element = h('section.trends', {}, h('p.crumbs', {}, h('a', {href: '#/nights'}, 'Nights')), this.#head,
      h('div.choices', {}, h('label', {}, h('span', {}, 'Cell'), this.#choice), h('span.spacer', {}), h('button', {type: 'button', onclick: () => this.#report()}, 'Report'), this.#csv, this.#csvAll),
      h('p.quiet.note', {}, 'Shaded: what the gates allowed. Full lines upright: an approved night. Dashed: another commit. Red: a number that moved.'), this.#body);
    setKeys('Trends', [
      {keys: ['n'], text: 'next cell', act: () => this.#open(this.#choice.selectedIndex + 1)},
      {keys: ['p'], text: 'previous cell', act: () => this.#open(this.#choice.selectedIndex - 1)},
      {keys: ['r'], text: 'report of what is on the screen', act: () => this.#report()},
    ]);
  }

  #report() {
    saveReport(`trends-${this.#name}`, {title: `Trends of ${this.#name}: ${this.#choice.selectedOptions[0]?.textContent ?? ''}`, address: location.href, parts: [{html: printed(this.#body)}]});
  }

  async load() {
    const {nights} = await get(`/api/nights?name=${encodeURIComponent(this.#name)}&limit=20`);
    const newest = nights.find(({status}) => status === 'passed' || status === 'failed');
    const {cells} = newest ? await get(`/api/nights/${newest.id}`) : {cells: []};
    this.#cells = cells.filter(({status}) => status !== 'missing').map(({capture, technique}) => ({capture, technique}));
    let index = this.#cells.findIndex(({capture, technique}) => capture === this.#cell.capture && technique === this.#cell.technique);
    if (index < 0 && this.#cell.capture) index = this.#cells.push(this.#cell) - 1;  // of an older night
    replace(this.#choice, this.#cells.map(({capture, technique}) => h('option', {}, `${capture}, ${technique}`)));
    this.#csvAll.href = `/api/nights/trends.csv?${new URLSearchParams({name: this.#name})}`;
    this.#head.textContent = `Trends of ${this.#name}`;
    if (this.#cells.length === 0) return replace(this.#body, h('p.quiet', {}, 'No finished night of this name.'));
    await this.#open(Math.max(index, 0));
  }

  async #open(index) {
    const cell = this.#cells[index];
    if (!cell) return;
    const turn = ++this.#turn;
    this.#choice.selectedIndex = index;
    history.replaceState(null, '', trendAddress(this.#name, cell.capture, cell.technique));
    const query = new URLSearchParams({name: this.#name, ...cell});
    this.#csv.href = `/api/nights/trends.csv?${query}`;
    try {
      const [{trends: [trend]}, UPlot] = await Promise.all([get(`/api/nights/trends?${query}`), loadPlots()]);
      if (turn === this.#turn) this.#draw(trend, UPlot);
    } catch (error) {
      if (turn === this.#turn) replace(this.#body, h('p.problem', {role: 'alert'}, error.message));
    }
  }

  #draw(trend, UPlot) {
    this.#drop();
    announce(`${trend.capture}, ${trend.technique}: ${trend.changes.length} changes`);
    const numbers = [...new Set(trend.nights.flatMap(({values}) => Object.keys(values)))].sort((a, b) => order(a) - order(b) || a.localeCompare(b));
    replace(this.#body, h('h2', {}, 'Where numbers moved'), changesList(trend), h('h2', {}, 'Numbers'),
      h('div.trend-plots', {}, numbers.map((number) => this.#figure(trend, number, UPlot))), valuesTable(trend, numbers));
  }

  #figure(trend, number, UPlot) {
    const changes = trend.changes.filter((change) => change.number === number);
    const values = trend.nights.map((night) => night.values[number] ?? null);
    const known = values.filter((value) => value !== null);
    const words = `${titleOf(number)} over ${known.length} nights, from ${significant(known[0], 4)} to ${significant(known.at(-1), 4)}, ${changes.length === 0 ? 'no change' : changes.map(({text}) => text).join('; ')}`;
    const place = h('div.trend-plot', {role: 'img', 'aria-label': words});
    const figure = h('figure', {}, h('figcaption', {}, titleOf(number), changes.length > 0 && h('span.moved', {}, ` moved ${changes.length === 1 ? 'once' : `${changes.length} times`}`)), place);
    // It has a width once it is on the page.
    requestAnimationFrame(() => {
      if (!place.isConnected) return;
      const low = trend.nights.map((night) => night.bands[number]?.low ?? null);
      const high = trend.nights.map((night) => night.bands[number]?.high ?? null);
      const plot = new UPlot(options(trend, values, low, high, changes, place), [trend.nights.map((_, i) => i), values, low, high], place);
      this.#plots.push({plot, place});
      this.#resize.observe(place);
    });
    return figure;
  }

  #drop() {
    this.#resize.disconnect();
    this.#plots.forEach(({plot}) => plot.destroy());
    this.#plots = [];
  }

  close() {
    ++this.#turn;
    this.#drop();
    setKeys('Trends');
  }
}

function options(trend, values, low, high, changes, place) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name).trim();
  const [ink, line, accent, bad, good] = ['--ink', '--line', '--accent', '--bad', '--good'].map(colour);
  const axis = {stroke: ink, grid: {stroke: line, width: 1}, ticks: {stroke: line}};
  const all = [...values, ...low, ...high].filter((value) => value !== null);
  const [least, most] = [Math.min(...all), Math.max(...all)];
  const room = (most - least) * 0.12 || Math.abs(most) * 0.05 || 1;
  const shade = `color-mix(in srgb, ${good} 16%, transparent)`;
  // A gate that is open below shades down to the floor.
  const bottom = least - room;
  const floor = high.map((value, i) => (value === null ? null : low[i] ?? bottom));
  low.splice(0, low.length, ...floor);
  return {
    width: place.clientWidth || 400, height: plotHeight, legend: {show: false}, cursor: {drag: {x: false, y: false}, points: {size: 6}},
    scales: {x: {time: false, range: () => [-0.5, trend.nights.length - 0.5]}, y: {range: () => [bottom, most + room]}},
    axes: [{...axis, label: 'Night', labelSize: 20, size: 34, incrs: [1, 2, 5, 10, 20, 50, 100], values: (_, ticks) => ticks.map((i) => trend.nights[i]?.night ?? '')},
      {...axis, size: 70, values: (_, ticks) => ticks.map((value) => tickText(value))}],
    series: [{}, {label: 'value', stroke: accent, width: 1.8, spanGaps: true, points: {show: true, size: 5}},
      {label: 'low', stroke: 'transparent', points: {show: false}}, {label: 'high', stroke: 'transparent', points: {show: false}}],
    bands: [{series: [3, 2], fill: shade}],
    hooks: {
      draw: [(plot) => {
        const upright = (at, stroke, dash) => {
          const x = Math.round(plot.valToPos(at, 'x', true)) + 0.5;
          Object.assign(plot.ctx, {strokeStyle: stroke, lineWidth: devicePixelRatio});
          plot.ctx.setLineDash(dash);
          plot.ctx.beginPath();
          plot.ctx.moveTo(x, plot.bbox.top);
          plot.ctx.lineTo(x, plot.bbox.top + plot.bbox.height);
          plot.ctx.stroke();
          plot.ctx.setLineDash([]);
        };
        trend.nights.forEach((night, i) => {
          if (night.approved) upright(i, good, []);
          if (i > 0 && night.commit !== trend.nights[i - 1].commit) upright(i - 0.5, ink, [3, 4]);
        });
        for (const change of changes) upright(trend.nights.findIndex(({night}) => night === change.after) - 0.5, bad, []);
      }],
      ready: [(plot) => plot.over.addEventListener('click', () => {
        if (plot.cursor.idx !== null) location.hash = `#/nights/${trend.nights[plot.cursor.idx].night}`;
      })],
    },
  };
}

function changesList(trend) {
  if (trend.changes.length === 0) return h('p.quiet', {}, 'None of its numbers moved.');
  return h('ul.changes', {}, trend.changes.map((change) => h('li', {}, h('strong', {}, titleOf(change.number)), ' ',
    `${significant(change.from, 5)} to ${significant(change.to, 5)}${change.from ? ` (${change.to > change.from ? '+' : ''}${(100 * (change.to / change.from - 1)).toFixed(2)}%)` : ''}, between `,
    h('a', {href: `#/nights/${change.before}`}, `night ${change.before}`), ' and ', h('a', {href: `#/nights/${change.after}`}, `night ${change.after}`),
    change.p === null ? '' : `, p ${change.p.toPrecision(2)}`)));
}

function valuesTable(trend, numbers) {
  return h('details', {}, h('summary', {}, 'All numbers'), h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'All numbers'}, h('table', {},
    h('thead', {}, h('tr', {}, ['Night', 'Started', 'Commit', 'Approved'].map((name) => h('th', {scope: 'col'}, name)), numbers.map((number) => h('th.number', {scope: 'col'}, titleOf(number))))),
    h('tbody', {}, trend.nights.map((night) => h('tr', {}, h('th', {scope: 'row'}, h('a', {href: `#/nights/${night.night}`}, `#${night.night}`)), h('td', {}, when(night.started_utc)),
      h('td', {}, commitText(night.commit)), h('td', {}, night.approved ? 'yes' : ''), numbers.map((number) => h('td.number', {}, night.values[number] === undefined ? '–' : significant(night.values[number], 6)))))))));
}
