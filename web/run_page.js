// One run: its progress while it lasts, its figures, plots and images, alone or beside another run of the capture.
import {advisor} from './advisor.js';
import {followRun, get, loadPalettes, techniques} from './api.js';
import {announce, field, h, replace} from './dom.js';
import {download} from './files.js';
import {when} from './format.js';
import {setKeys} from './keys.js';
import {Later} from './later.js';
import {measured, measureOf} from './measures.js';
import {OverFrames} from './over_frames.js';
import {Playback} from './playback.js';
import {panelParts, picturePart, printed, saveReport, tableHtml} from './report.js';
import {passBars} from './result_details.js';
import {arrange, ResultsTable, tableMarkdown} from './results_table.js';
import {factsOf, RunHead} from './run_head.js';
import {RunImages} from './run_images.js';
import {baselineOf, figuresOf, rowsOf, takeResults} from './run_rows.js';
import {Scatter} from './scatter.js';
import {viewHints, viewKeys} from './view_input.js';
import {ViewAddress} from './view_address.js';

export async function runPage(id) {
  const address = new ViewAddress();
  const [run, registry] = await Promise.all([get(`/api/runs/${id}`), techniques(), loadPalettes()]);
  const page = new RunPage(run, registry, address);
  await page.start();
  return {element: page.element, title: `Run ${id}`, close: () => page.close()};
}

class RunPage {
  #registry;
  #address;
  #shown;              // {run, rows, row, frame}: rows of this run, then of the other one; `row` is the one that "*" in a layer's key means
  #overFrames;         // the table shows means
  #order;              // of the table: {sort, descending, filter, group}
  #other = null;       // the run beside this one
  #closed = false;
  #stopFollowing = () => {};
  #drawing = 0;
  #linesTimer = 0;
  #head = new RunHead();
  #table = new ResultsTable({select: (row) => this.#setRow(row), sort: (key) => this.#sortBy(key)});
  #note = h('p.quiet.note', {});
  #passes = h('div', {});
  #images;
  #playback;
  #scatter;
  #lines;
  #advisor;
  #later = [new Later(this.#table.element, () => this.#drawTable()), new Later(this.#passes, () => replace(this.#passes, passBars(this.#figures().rows)))];
  #techniqueSelect = h('select', {onchange: () => this.#setRow(Number(this.#techniqueSelect.value))});
  #filter = h('input', {type: 'search', placeholder: 'words of the label', oninput: () => this.#setOrder({filter: this.#filter.value})});
  #means = h('input', {type: 'checkbox', onchange: () => this.#setMeans(this.#means.checked)});
  #otherSelect = h('select', {onchange: () => this.#compareWith(Number(this.#otherSelect.value))});

  constructor(run, registry, address) {
    this.#registry = registry;
    this.#address = address;
    const rows = rowsOf(run, registry, true);
    const [first, last] = run.request.frames;
    // The most telling first view is of what is compared, not of the baselines.
    const telling = Math.max(0, rows.findLastIndex((row) => row.technique !== 'noaa'));
    this.#shown = {run, rows, row: address.number('row', telling), frame: Math.min(Math.max(address.number('frame', first), first), last)};
    this.#overFrames = this.#means.checked = address.flag('means');
    this.#order = {sort: address.text('sort'), descending: address.flag('descending'), filter: address.text('filter'), group: address.text('group')};
    this.#filter.value = this.#order.filter;
    this.#images = new RunImages(this.#shown, address);
    this.#playback = new Playback(run.request.frames, (frame) => this.#setFrame(frame), () => this.#images.view.settled);
    this.#playback.show(this.#shown.frame);
    this.#makePlots();
    this.#advisor = advisor(run.id, registry);
    this.element = this.#build();
    this.#drawTechniques();
    this.#bindKeys();
  }

  #makePlots() {
    const {run} = this.#shown;
    const address = this.#address;
    const referenced = run.request.reference_samples > 0;
    const name = `run-${run.id}`;
    const plot = {x: address.text('across', 'total'), y: address.text('upwards', referenced ? 'mse' : 'fitted'), logX: address.flag('logx'), logY: address.flag('logy')};
    if (!measureOf(plot.x)) plot.x = 'total';
    if (!measureOf(plot.y)) plot.y = 'mse';
    this.#scatter = new Scatter(plot, name, {select: (row) => this.#setRow(row), change: ({x, y, logX, logY}) => address.set({across: x, upwards: y, logx: logX, logy: logY})});
    const lines = {measure: address.text('lines', referenced ? 'mse' : 'total'), log: address.flag('loglines'), hidden: address.text('without').split('~').filter(Boolean)};
    if (!measureOf(lines.measure)) lines.measure = 'total';
    this.#lines = new OverFrames(lines, name, {frame: (frame) => this.#setFrame(frame), change: ({measure, log, hidden}) => address.set({lines: measure, loglines: log, without: hidden.join('~')})});
    this.#scatter.controls.append(h('a.button', {href: `/api/runs/${run.id}/points.csv`, download: `${name}-points.csv`}, 'Points as CSV'),
      h('a.button', {href: `/api/runs/${run.id}/points.md`, download: `${name}-points.md`}, 'Points as Markdown'));
  }

  #build() {
    const {run} = this.#shown;
    const title = run.capture.title || run.capture.name;
    const [first, last] = run.request.frames;
    const groups = [['', 'not grouped'], ['technique', 'by technique'], ['run', 'by run']];
    const group = h('select', {onchange: () => this.#setOrder({group: group.value})}, groups.map(([value, text]) => h('option', {value, selected: value === this.#order.group}, text)));
    const images = this.#images;
    return h('section.run-page', {},
      h('p.crumbs', {}, h('a', {href: '#/runs'}, 'Runs'), ' / ', h('a', {href: `#/captures/${run.capture.hash}`}, title)),
      h('div.section-head.first', {}, h('h1', {}, `Run ${run.id}`, h('span.quiet', {}, ` ${title}`)), h('span.spacer', {}),
        field('beside', this.#otherSelect),
        h('button', {type: 'button', onclick: () => this.#address.copy()}, 'Copy address'), h('button', {type: 'button', onclick: () => this.#report()}, 'Report')),
      this.#head.progress,
      h('div.section-head', {}, h('h2', {}, 'Figures'), last > first && h('label.check', {}, this.#means, 'means over all frames'),
        field('filter', this.#filter), field('group', group), h('span.spacer', {}),
        h('a.button', {href: `/api/runs/${run.id}/results.csv`, download: `run-${run.id}-results.csv`}, 'CSV'),
        h('a.button', {href: `/api/runs/${run.id}/results.json`, download: `run-${run.id}-results.json`}, 'JSON'),
        h('button', {type: 'button', onclick: () => download(`run-${run.id}-figures.md`, 'text/markdown', this.#markdown())}, 'Markdown')),
      this.#table.element, this.#note,
      h('div.section-head', {}, h('h2', {}, 'Images'),
        last > first && h('div.field.frame', {}, h('label', {}, 'Frame ', this.#playback.number, this.#playback.slider)), last > first && this.#playback.button,
        field('technique', this.#techniqueSelect)),
      images.chips, images.state, images.view.element, images.story.element, images.layerList, images.files,
      h('details', {}, h('summary', {}, 'Executions and counters'), images.details),
      h('h2', {}, 'Measure against measure'), this.#scatter.element,
      last > first && [h('h2', {}, 'Over frames'), this.#lines.element],
      h('details', {}, h('summary', {}, 'Time by pass'), this.#passes),
      run.request.reference_samples > 0 && [h('h2', {}, 'Advisor'), this.#advisor.element],
      h('h2', {}, 'What was run'), this.#head.facts);
  }

  async start() {
    this.#head.draw(this.#shown.run);
    const other = this.#address.number('with', 0);
    this.#listRuns();
    if (other > 0) await this.#compareWith(other).catch(() => {});
    this.#shown.row = Math.min(this.#shown.row, this.#shown.rows.length - 1);
    this.#drawTechniques();
    this.#draw();
    this.#stopFollowing = followRun(this.#shown.run.id, {
      result: ({ordinal, result}) => this.#take(ordinal, result),
      status: (status) => {
        Object.assign(this.#shown.run, status);
        this.#head.drawProgress(this.#shown.run);
      },
      end: (status) => this.#ended(status),
      lost: () => this.#head.lost(),
    });
  }

  close() {
    this.#closed = true;
    this.#address.write();
    this.#stopFollowing();
    for (const part of [this.#images, this.#playback, this.#scatter, this.#lines, ...this.#later]) part.close();
    clearTimeout(this.#linesTimer);
    cancelAnimationFrame(this.#drawing);
    for (const group of ['This run', 'Picture', 'On the picture']) setKeys(group);
  }

  #bindKeys() {
    const shown = this.#shown;
    setKeys('This run', [
      {keys: ['['], text: 'frame before', act: () => this.#setFrame(shown.frame - 1)},
      {keys: [']'], text: 'next frame', act: () => this.#setFrame(shown.frame + 1)},
      {keys: ['p'], text: 'play the frames, or stop', act: () => this.#playback.toggle()},
      {keys: ['j'], text: 'next technique', act: () => this.#setRow(shown.row + 1)},
      {keys: ['k'], text: 'technique before', act: () => this.#setRow(shown.row - 1)},
      {keys: ['a'], text: 'means over all frames', act: () => this.#setMeans(!this.#overFrames)},
      {keys: ['/'], text: 'filter the figures', act: () => this.#filter.focus()},
      {keys: ['r'], text: 'report of what is on the screen', act: () => this.#report()},
      {keys: ['y'], text: 'copy the address of this view', act: () => this.#address.copy()},
    ]);
    setKeys('Picture', viewKeys(this.#images.view));
    setKeys('On the picture', viewHints);
  }

  // Another run beside ------------------------------------------------------------------------------------------

  async #listRuns() {
    const {run} = this.#shown;
    let runs = [];
    try {
      ({runs} = await get(`/api/runs?capture=${run.capture.hash}&limit=50`));
    } catch {
      // Then there is none to choose.
    }
    const others = runs.filter(({id}) => id !== run.id);
    this.#otherSelect.disabled = others.length === 0;
    replace(this.#otherSelect, h('option', {value: 0}, others.length > 0 ? 'no other run' : 'there is no other run'),
      others.map(({id, created_utc: created}) => h('option', {value: id, selected: id === this.#other?.id}, `run ${id}, ${when(created)}`)));
  }

  async #compareWith(id) {
    const shown = this.#shown;
    shown.rows = shown.rows.filter((row) => row.run === shown.run.id);
    this.#other = null;
    if (id > 0) {
      try {
        const [other, {results}] = await Promise.all([get(`/api/runs/${id}`), get(`/api/runs/${id}/results.json`)]);
        const rows = rowsOf(other, this.#registry, false);
        takeResults(rows, results);
        shown.rows.push(...rows);
        this.#other = other;
      } catch (error) {
        announce(error.message);
      }
    }
    shown.row = Math.min(shown.row, shown.rows.length - 1);
    this.#address.set({with: this.#other?.id});
    this.#otherSelect.value = this.#other?.id ?? 0;
    this.#drawTechniques();
    this.#draw();
    this.#drawLines();
  }

  // What comes in -----------------------------------------------------------------------------------------------

  #take(ordinal, result) {
    this.#shown.rows[ordinal].results.set(result.frame, result);
    if (!this.#shown.run.head) this.#refreshHead();
    // Many results can come at once; one drawing for all of them, unless what is shown can't have changed.
    if (this.#overFrames || result.frame === this.#shown.frame) this.#drawSoon();
    this.#linesTimer ||= setTimeout(() => this.#drawLines(), 400);
  }

  async #refreshHead() {
    const {run} = this.#shown;
    try {
      Object.assign(run, await get(`/api/runs/${run.id}`), {stored_results: run.stored_results});
      this.#head.draw(run);
    } catch {
      // The next result or the end asks again.
    }
  }

  async #ended(status) {
    const {run, rows} = this.#shown;
    Object.assign(run, status);
    announce(`Run ${run.id} ${status.status}`);
    await this.#refreshHead();
    this.#head.draw(run);
    this.#drawSoon();
    this.#drawLines();
    // The form's first budget is one of FLIP.
    if (rows.some((row) => [...row.results.values()].some((result) => Number.isFinite(result.error.flip_mean)))) this.#advisor.ask();
  }

  // What the user changes -----------------------------------------------------------------------------------------

  #setFrame(frame) {
    const [first, last] = this.#shown.run.request.frames;
    if (frame < first || frame > last) return;
    this.#shown.frame = frame;
    this.#playback.show(frame);
    this.#address.set({frame: frame === first ? null : frame});
    this.#lines.setFrame(frame);
    this.#drawSoon();
  }

  #setRow(row) {
    if (row < 0 || row >= this.#shown.rows.length) return;
    this.#shown.row = row;
    this.#techniqueSelect.value = row;
    this.#address.set({row});
    this.#drawSoon();
  }

  #setMeans(on) {
    this.#overFrames = this.#means.checked = on;
    this.#address.set({means: on});
    this.#drawFigures();
  }

  #setOrder(change) {
    Object.assign(this.#order, change);
    const {sort, descending, filter, group} = this.#order;
    this.#address.set({sort, descending, filter, group});
    this.#drawFigures();
  }

  #sortBy(key) {
    const first = key !== 'label' && measureOf(key).better > 0;  // the best first
    if (this.#order.sort !== key) this.#setOrder({sort: key, descending: first});
    else if (this.#order.descending === first) this.#setOrder({descending: !first});
    else this.#setOrder({sort: '', descending: false});
  }

  // Drawing -------------------------------------------------------------------------------------------------------

  #drawTechniques() {
    replace(this.#techniqueSelect, this.#shown.rows.map(({label}, i) => h('option', {value: i, selected: i === this.#shown.row}, label)));
  }

  #figures() {
    const {run, rows, row, frame} = this.#shown;
    const figures = figuresOf(rows, row, this.#overFrames ? null : frame);
    const baseline = baselineOf(run, rows);
    const summary = baseline ? figures[rows.indexOf(baseline)].summary : null;
    const note = summary ? `Ratios are to ${baseline.label}${this.#overFrames ? ', means over the frames measured so far' : ` in frame ${frame}`}. ● best, ≈ within the spread of the best.` : '';
    return {rows: figures, summary, note, groups: arrange(figures, this.#order, summary)};
  }

  #markdown() {
    const {groups, summary} = this.#figures();
    return tableMarkdown(groups, summary);
  }

  #drawSoon() {
    this.#drawing ||= requestAnimationFrame(() => this.#draw());
  }

  // The picture at once, what belongs to it in tasks of their own.
  #draw() {
    cancelAnimationFrame(this.#drawing);
    this.#drawing = 0;
    this.#images.draw(this.#playback.playing);
    for (const part of this.#later) part.ask();
  }

  #drawFigures() {
    for (const part of this.#later) {
      part.ask();
      part.now();
    }
  }

  #drawTable() {
    const {summary, note, groups} = this.#figures();
    this.#table.draw(groups, summary, this.#order);
    this.#note.textContent = note;
    this.#scatter.draw(groups.flatMap((group) => group.rows), summary);
  }

  #drawLines() {
    clearTimeout(this.#linesTimer);
    this.#linesTimer = 0;
    const {run, rows, frame: now} = this.#shown;
    const [first, last] = run.request.frames;
    if (last === first || this.#closed) return;
    const frames = Array.from({length: last - first + 1}, (_, i) => first + i);
    this.#lines.draw(frames, rows.map(({label, results}) => ({label, of: (key) => frames.map((frame) => {
      const result = results.get(frame);
      return result ? measured(result, key) : null;
    })})), now);
  }

  #report() {
    this.#address.write();
    const {run, frame} = this.#shown;
    const {groups, summary, note} = this.#figures();
    const [first, last] = run.request.frames;
    const {view, story} = this.#images;
    const labels = view.layers.map(({label}, i) => `${i + 1} ${label}`).join(', ');
    saveReport(`run-${run.id}`, {
      title: `Run ${run.id}: ${run.capture.title || run.capture.name}`, address: location.href, facts: [...factsOf(run), ['frame', frame]],
      parts: [
        {title: 'Figures', html: `${tableHtml(tableMarkdown(groups, summary))}${printed(h('p', {}, note))}`},
        picturePart(view, `Frame ${frame}; ${view.state.mode}; layers ${labels}`), ...panelParts(view),
        !story.element.hidden && {html: printed(story.element)},
        {title: 'Measure against measure', html: this.#scatter.text()},
        last > first && {title: `Over frames: ${this.#lines.title}`, html: this.#lines.text()},
        this.#passes.parentElement.open && {title: 'Time by pass', html: printed(this.#passes)},
      ].filter(Boolean),
    });
  }
}
