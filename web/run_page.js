// One run: its progress while it lasts, its figures, plots and images, alone or beside another run of the capture.
import {advisor} from './advisor.js';
import {blobUrl, followRun, get, loadPalettes, post, remove, techniques} from './api.js';
import {CompareView, maxLayers} from './compare_view.js';
import {announce, field, h, replace} from './dom.js';
import {download} from './files.js';
import {count, duration, fixed, techniqueLabel, when} from './format.js';
import {setKeys} from './keys.js';
import {defaultBaseline, measured, measureOf, summarise} from './measures.js';
import {OverFrames} from './over_frames.js';
import {PixelStory} from './pixel_story.js';
import {saveReport} from './report.js';
import {arrange, executionHistogram, passBars, resultsTable, tableMarkdown} from './results_table.js';
import {layerOf, rank, rolesOf, roleTitle} from './run_layers.js';
import {frameRange, runSize, statusPill} from './runs_page.js';
import {Scatter} from './scatter.js';
import {loadView, saveView, ViewAddress} from './view_address.js';

const framesPerSecond = 8;
const framesAhead = 3;

export async function runPage(id) {
  const address = new ViewAddress();
  const [run, registry] = await Promise.all([get(`/api/runs/${id}`), techniques(), loadPalettes()]);
  const page = new RunPage(run, registry, address);
  await page.start();
  return {element: page.element, title: `Run ${id}`, close: () => page.close()};
}

// A row for each technique of a run's request.
function rowsOf(run, registry, own) {
  return run.request.techniques.map(({technique, parameters}) => {
    const entry = registry.find((candidate) => candidate.name === technique);
    const label = techniqueLabel(technique, parameters, entry);
    return {technique, parameters, entry, run: run.id, label: own ? label : `${label} (run ${run.id})`, results: new Map()};
  });
}

class RunPage {
  #run;
  #registry;
  #address;
  #rows;               // of this run, then of the other one: {technique, parameters, label, entry, run, results: Map by frame}
  #frame;
  #row = 0;            // the technique that "*" in a layer's key means
  #overFrames;         // the table shows means
  #order;              // of the table: {sort, descending, filter, group}
  #layerKeys;
  #other = null;       // the run beside this one
  #playing = 0;
  #closed = false;
  #view = new CompareView((state) => {
    saveView(this.#address, state);
    this.#drawChips();
  });
  #story = new PixelStory();
  #stopFollowing = () => {};
  #drawing = 0;
  #linesTimer = 0;
  #progress = h('div.progress', {});
  #facts = h('dl.facts.wide', {});
  #table = h('div', {});
  #note = h('p.quiet.note', {});
  #passes = h('div', {});
  #scatter;
  #lines;
  #advisor;
  #chips = h('div.chips', {role: 'group', 'aria-label': 'What is shown'});
  #layerList = h('div.layer-list', {});
  #imageState = h('p.quiet', {role: 'status'});
  #files = h('p.files', {});
  #details = h('div.result-details', {});
  #slider = h('input', {type: 'range', step: 1, oninput: () => this.#setFrame(this.#slider.valueAsNumber)});
  #frameText = h('output.frame-number', {});
  #play = h('button', {type: 'button', 'aria-pressed': 'false', onclick: () => this.#togglePlay()}, 'Play');
  #techniqueSelect = h('select', {onchange: () => this.#setRow(Number(this.#techniqueSelect.value))});
  #filter = h('input', {type: 'search', placeholder: 'words of the label', oninput: () => this.#setOrder({filter: this.#filter.value})});
  #means = h('input', {type: 'checkbox', onchange: () => this.#setMeans(this.#means.checked)});
  #otherSelect = h('select', {onchange: () => this.#compareWith(Number(this.#otherSelect.value))});

  constructor(run, registry, address) {
    this.#run = run;
    this.#registry = registry;
    this.#address = address;
    this.#rows = rowsOf(run, registry, true);
    const [first, last] = run.request.frames;
    this.#frame = Math.min(Math.max(address.number('frame', first), first), last);
    for (const [name, value] of [['min', first], ['max', last]]) this.#slider.setAttribute(name, value);
    this.#slider.value = this.#frame;
    // The most telling first view is of what is compared, not of the baselines.
    const telling = Math.max(0, this.#rows.findLastIndex((row) => row.technique !== 'noaa'));
    this.#row = address.number('row', telling);
    this.#overFrames = address.flag('means');
    this.#means.checked = this.#overFrames;
    this.#order = {sort: address.text('sort'), descending: address.flag('descending'), filter: address.text('filter'), group: address.text('group')};
    this.#filter.value = this.#order.filter;
    const baseline = this.#baseline();
    const referenced = run.request.reference_samples > 0;
    const usual = referenced ? ['*:image', '*:reference', '*:error', '*:shading'] : ['*:image', ...(baseline ? [`${this.#rows.indexOf(baseline)}:image`] : []), '*:shading'];
    this.#layerKeys = address.text('layers') ? address.text('layers').split(',').slice(0, maxLayers) : usual;
    const name = `run-${run.id}`;
    const plot = {x: address.text('across', 'total'), y: address.text('upwards', referenced ? 'mse' : 'fitted'), logX: address.flag('logx'), logY: address.flag('logy')};
    if (!measureOf(plot.x)) plot.x = 'total';
    if (!measureOf(plot.y)) plot.y = 'mse';
    this.#scatter = new Scatter(plot, name, {select: (row) => this.#setRow(row),
      change: ({x, y, logX, logY}) => this.#address.set({across: x, upwards: y, logx: logX, logy: logY})});
    const lines = {measure: address.text('lines', referenced ? 'mse' : 'total'), log: address.flag('loglines')};
    if (!measureOf(lines.measure)) lines.measure = 'total';
    this.#lines = new OverFrames(lines, name, {frame: (frame) => this.#setFrame(frame), change: ({measure, log}) => this.#address.set({lines: measure, loglines: log})});
    this.#scatter.controls.append(h('a.button', {href: `/api/runs/${run.id}/points.csv`, download: `${name}-points.csv`}, 'Points as CSV'),
      h('a.button', {href: `/api/runs/${run.id}/points.md`, download: `${name}-points.md`}, 'Points as Markdown'));
    this.#advisor = advisor(run.id, registry);
    this.element = this.#build();
    this.#drawTechniques();
    this.#bindKeys();
  }

  #build() {
    const run = this.#run;
    const title = run.capture.title || run.capture.name;
    const [first, last] = run.request.frames;
    const groups = [['', 'not grouped'], ['technique', 'by technique'], ['run', 'by run']];
    const group = h('select', {onchange: () => this.#setOrder({group: group.value})}, groups.map(([value, text]) => h('option', {value, selected: value === this.#order.group}, text)));
    return h('section.run-page', {},
      h('p.crumbs', {}, h('a', {href: '#/runs'}, 'Runs'), ' / ', h('a', {href: `#/captures/${run.capture.hash}`}, title)),
      h('div.section-head.first', {}, h('h1', {}, `Run ${run.id}`, h('span.quiet', {}, ` ${title}`)), h('span.spacer', {}),
        field('beside', this.#otherSelect),
        h('button', {type: 'button', onclick: () => this.#copyAddress()}, 'Copy address'), h('button', {type: 'button', onclick: () => this.#report()}, 'Report')),
      this.#progress,
      h('div.section-head', {}, h('h2', {}, 'Figures'), last > first && h('label.check', {}, this.#means, 'means over all frames'),
        field('filter', this.#filter), field('group', group), h('span.spacer', {}),
        h('a.button', {href: `/api/runs/${run.id}/results.csv`, download: `run-${run.id}-results.csv`}, 'CSV'),
        h('a.button', {href: `/api/runs/${run.id}/results.json`, download: `run-${run.id}-results.json`}, 'JSON'),
        h('button', {type: 'button', onclick: () => download(`run-${run.id}-figures.md`, 'text/markdown', this.#markdown())}, 'Markdown')),
      this.#table, this.#note,
      h('div.section-head', {}, h('h2', {}, 'Images'),
        last > first && h('div.field.frame', {}, h('label', {}, 'Frame ', this.#frameText, this.#slider)), last > first && this.#play,
        field('technique', this.#techniqueSelect)),
      this.#chips, this.#imageState, this.#view.element, this.#story.element, this.#layerList, this.#files,
      h('details', {}, h('summary', {}, 'Executions and counters'), this.#details),
      h('h2', {}, 'Measure against measure'), this.#scatter.element,
      last > first && [h('h2', {}, 'Over frames'), this.#lines.element],
      h('details', {}, h('summary', {}, 'Time by pass'), this.#passes),
      run.request.reference_samples > 0 && [h('h2', {}, 'Advisor'), this.#advisor.element],
      h('h2', {}, 'What was run'), this.#facts);
  }

  async start() {
    this.#view.element.addEventListener('pixelchosen', ({detail: {x, y, layer}}) => {
      const index = layer?.key.split(':')[0] ?? '*';  // a layer's key begins with its row, or "*" for the selected one
      const {technique, parameters} = this.#rows[index === '*' ? this.#row : Number(index)] ?? this.#rows[this.#row];
      this.#story.show(this.#run, technique, parameters, this.#frame, {x, y});
    });
    this.#showRun();
    this.#view.restore(loadView(this.#address));
    const other = this.#address.number('with', 0);
    this.#listRuns();
    if (other > 0) await this.#compareWith(other).catch(() => {});
    this.#row = Math.min(this.#row, this.#rows.length - 1);
    this.#drawTechniques();
    this.#draw();
    this.#stopFollowing = followRun(this.#run.id, {
      result: ({ordinal, result}) => this.#take(ordinal, result),
      status: (status) => {
        Object.assign(this.#run, status);
        this.#showProgress();
      },
      end: (status) => this.#ended(status),
      lost: () => {
        this.#progress.classList.add('lost');
        announce('Connection lost, trying again');
      },
    });
  }

  close() {
    this.#closed = true;
    this.#address.write();
    this.#stopFollowing();
    this.#view.close();
    this.#lines.close();
    clearTimeout(this.#linesTimer);
    cancelAnimationFrame(this.#drawing);
    setKeys('This run');
    setKeys('Picture');
    setKeys('On the picture');
  }

  #bindKeys() {
    setKeys('This run', [
      {keys: ['['], text: 'frame before', act: () => this.#setFrame(this.#frame - 1)},
      {keys: [']'], text: 'next frame', act: () => this.#setFrame(this.#frame + 1)},
      {keys: ['p'], text: 'play the frames, or stop', act: () => this.#togglePlay()},
      {keys: ['j'], text: 'next technique', act: () => this.#setRow(this.#row + 1)},
      {keys: ['k'], text: 'technique before', act: () => this.#setRow(this.#row - 1)},
      {keys: ['a'], text: 'means over all frames', act: () => this.#setMeans(!this.#overFrames)},
      {keys: ['/'], text: 'filter the figures', act: () => this.#filter.focus()},
      {keys: ['r'], text: 'report of what is on the screen', act: () => this.#report()},
      {keys: ['y'], text: 'copy the address of this view', act: () => this.#copyAddress()},
    ]);
    setKeys('Picture', this.#view.keys());
    setKeys('On the picture', CompareView.hints);
  }

  // Another run beside ------------------------------------------------------------------------------------------

  async #listRuns() {
    let runs = [];
    try {
      ({runs} = await get(`/api/runs?capture=${this.#run.capture.hash}&limit=50`));
    } catch {
      // Then there is none to choose.
    }
    const others = runs.filter(({id}) => id !== this.#run.id);
    this.#otherSelect.disabled = others.length === 0;
    replace(this.#otherSelect, h('option', {value: 0}, others.length > 0 ? 'no other run' : 'there is no other run'),
      others.map(({id, created_utc: created}) => h('option', {value: id, selected: id === this.#other?.id}, `run ${id}, ${when(created)}`)));
  }

  async #compareWith(id) {
    this.#rows = this.#rows.filter((row) => row.run === this.#run.id);
    this.#other = null;
    if (id > 0) {
      try {
        const [other, {results}] = await Promise.all([get(`/api/runs/${id}`), get(`/api/runs/${id}/results.json`)]);
        const rows = rowsOf(other, this.#registry, false);
        const same = (row, result) => row.technique === result.technique && Object.entries(row.parameters).every(([name, value]) => result.parameters[name] === value);
        for (const result of results) rows.find((row) => same(row, result))?.results.set(result.frame, result);
        this.#rows.push(...rows);
        this.#other = other;
      } catch (error) {
        announce(error.message);
      }
    }
    this.#row = Math.min(this.#row, this.#rows.length - 1);
    this.#address.set({with: this.#other?.id});
    this.#otherSelect.value = this.#other?.id ?? 0;
    this.#drawTechniques();
    this.#draw();
    this.#drawLines();
  }

  // What comes in -----------------------------------------------------------------------------------------------

  #take(ordinal, result) {
    this.#rows[ordinal].results.set(result.frame, result);
    if (!this.#run.head) this.#refreshHead();
    // Many results can come at once; one drawing for all of them, unless what is shown can't have changed.
    if (this.#overFrames || result.frame === this.#frame) this.#drawSoon();
    this.#linesTimer ||= setTimeout(() => this.#drawLines(), 400);
  }

  #drawSoon() {
    this.#drawing ||= requestAnimationFrame(() => this.#draw());
  }

  async #refreshHead() {
    try {
      this.#run = {...(await get(`/api/runs/${this.#run.id}`)), stored_results: this.#run.stored_results};
      this.#showRun();
    } catch {
      // The next result or the end asks again.
    }
  }

  async #ended(status) {
    Object.assign(this.#run, status);
    announce(`Run ${this.#run.id} ${status.status}`);
    await this.#refreshHead();
    this.#showRun();
    this.#draw();
    this.#drawLines();
    // The form's first budget is one of FLIP.
    if (this.#rows.some((row) => [...row.results.values()].some((result) => Number.isFinite(result.error.flip_mean)))) this.#advisor.ask();
  }

  #factList() {
    const {head, request} = this.#run;
    return [
      ['started', when(this.#run.started_utc)],
      ['frames', frameRange(request.frames)],
      ['size', runSize(request, head?.width, head?.height)],
      ['reference', request.reference_samples > 0 ? `${request.reference_samples} samples` : 'none'],
      ['repeats', request.repeat],
      head && ['driver', `${head.driver} ${head.driver_version}`], head && ['device', head.device], head && ['CPU', head.cpu_model],
      head && ['triangles, first frame', count(head.triangles_first_frame)], head && ['point lights', head.point_lights],
      head && ['scene needs', head.features.join(', ') || 'nothing special'],
      head?.wall_s > 0 && ['wall time', `${duration(head.wall_s)}, ${fixed((100 * head.outside_gpu_s) / head.wall_s, 0)} % outside of passes`],
      head && ['build', head.build],
    ].filter(Boolean);
  }

  #showRun() {
    this.#showProgress();
    replace(this.#facts, this.#factList().map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value))));
  }

  #showProgress() {
    const {status, reason, stored_results: stored, expected_results: expected, progress} = this.#run;
    const active = status === 'queued' || status === 'running';
    this.#progress.classList.remove('lost');
    const act = async (action) => {
      try {
        await action();
      } catch (error) {
        announce(error.message);
      }
    };
    replace(this.#progress, statusPill(status),
      active && h('progress', {max: expected, value: stored, 'aria-label': 'Results'}),
      h('span', {}, `${stored} of ${expected} results`),
      active && progress && h('span.quiet', {}, `${progress.stage}: ${progress.detail}`),
      active && this.#remaining(),
      h('span.spacer', {}),
      active && h('button', {type: 'button', onclick: () => act(() => post(`/api/runs/${this.#run.id}/cancel`))}, 'Cancel run'),
      !active && h('button.danger', {type: 'button', onclick: () => act(async () => {
        if (!confirm(`Delete run ${this.#run.id} and its images?`)) return;
        await remove(`/api/runs/${this.#run.id}`);
        location.hash = '#/runs';
      })}, 'Delete run'),
      reason && h('p.problem', {role: 'alert'}, reason));
  }

  #remaining() {
    const {started_utc: started, stored_results: stored, expected_results: expected} = this.#run;
    if (!started || stored < 2) return null;
    const seconds = ((Date.now() - Date.parse(started)) / 1000 / stored) * (expected - stored);
    return h('span.quiet', {}, `about ${duration(seconds)} left`);
  }

  // What the user changes -----------------------------------------------------------------------------------------

  #setFrame(frame) {
    const [first, last] = this.#run.request.frames;
    if (frame < first || frame > last) return;
    this.#frame = frame;
    this.#slider.value = frame;
    this.#address.set({frame: frame === first ? null : frame});
    this.#lines.setFrame(frame);
    this.#drawSoon();
  }

  #setRow(row) {
    if (row < 0 || row >= this.#rows.length) return;
    this.#row = row;
    this.#techniqueSelect.value = row;
    this.#address.set({row});
    this.#drawSoon();
  }

  #setMeans(on) {
    this.#overFrames = on;
    this.#means.checked = on;
    this.#address.set({means: on});
    this.#draw();
  }

  #setOrder(change) {
    Object.assign(this.#order, change);
    const {sort, descending, filter, group} = this.#order;
    this.#address.set({sort, descending, filter, group});
    this.#draw();
  }

  #sortBy(key) {
    const first = key !== 'label' && measureOf(key).better > 0;  // the best first
    if (this.#order.sort !== key) this.#setOrder({sort: key, descending: first});
    else if (this.#order.descending === first) this.#setOrder({descending: !first});
    else this.#setOrder({sort: '', descending: false});
  }

  async #togglePlay() {
    const mine = this.#playing ? 0 : Date.now();
    this.#playing = mine;
    this.#play.setAttribute('aria-pressed', String(Boolean(mine)));
    this.#play.textContent = mine ? 'Stop' : 'Play';
    const [first, last] = this.#run.request.frames;
    while (mine && this.#playing === mine && !this.#closed) {
      const due = performance.now() + 1000 / framesPerSecond;
      this.#setFrame(this.#frame < last ? this.#frame + 1 : first);
      await new Promise(requestAnimationFrame);
      await this.#view.settled;
      await new Promise((resolve) => setTimeout(resolve, Math.max(0, due - performance.now())));
    }
  }

  async #copyAddress() {
    this.#address.write();
    try {
      await navigator.clipboard.writeText(location.href);
      announce('The address of this view is copied');
    } catch {
      announce('The address bar has the address of this view');
    }
  }

  // Drawing -------------------------------------------------------------------------------------------------------

  #drawTechniques() {
    replace(this.#techniqueSelect, this.#rows.map(({label}, i) => h('option', {value: i, selected: i === this.#row}, label)));
  }

  // The rows as the table and the plots take them.
  #shownRows() {
    const families = [...new Set(this.#rows.map(({technique}) => technique))];
    return this.#rows.map((row, i) => {
      const results = this.#overFrames ? [...row.results.values()] : [row.results.get(this.#frame)].filter(Boolean);
      return {label: row.label, technique: row.technique, family: families.indexOf(row.technique), run: row.run, select: i, selected: i === this.#row, summary: results.length > 0 ? summarise(results) : null};
    });
  }

  // All times are compared with this run's.
  #baseline() {
    return defaultBaseline(this.#run, this.#rows.filter((row) => row.run === this.#run.id));
  }

  #figures() {
    const rows = this.#shownRows();
    const baseline = this.#baseline();
    const summary = baseline ? rows[this.#rows.indexOf(baseline)].summary : null;
    const note = summary ? `Ratios are to ${baseline.label}${this.#overFrames ? ', means over the frames measured so far' : ` in frame ${this.#frame}`}. ● best, ≈ within the spread of the best.` : '';
    return {rows, summary, note, groups: arrange(rows, this.#order, summary)};
  }

  #markdown() {
    const {groups, summary} = this.#figures();
    return tableMarkdown(groups, summary);
  }

  #draw() {
    cancelAnimationFrame(this.#drawing);
    this.#drawing = 0;
    this.#frameText.textContent = `${this.#frame}`;
    const {rows, summary, note, groups} = this.#figures();
    const active = this.#table.contains(document.activeElement) ? document.activeElement.dataset : {};
    replace(this.#table, resultsTable(groups, summary, this.#order, {select: (row) => this.#setRow(row), sort: (key) => this.#sortBy(key)}));
    this.#note.textContent = note;
    if (active.row !== undefined) this.#table.querySelector(`[data-row="${this.#row}"]`)?.focus();
    if (active.sort !== undefined) this.#table.querySelector(`[data-sort="${active.sort}"]`)?.focus();
    replace(this.#passes, passBars(rows));
    this.#scatter.draw(groups.flatMap((group) => group.rows), summary);
    this.#drawImages();
  }

  #drawLines() {
    clearTimeout(this.#linesTimer);
    this.#linesTimer = 0;
    const [first, last] = this.#run.request.frames;
    if (last === first || this.#closed) return;
    const frames = Array.from({length: last - first + 1}, (_, i) => first + i);
    this.#lines.draw(frames, this.#rows.map(({label, results}) => ({label, of: (key) => frames.map((frame) => {
      const result = results.get(frame);
      return result ? measured(result, key) : null;
    })})), this.#frame);
  }

  #layer(key, frame = this.#frame) {
    const [place, role] = key.split(':');
    const row = this.#rows[place === '*' ? this.#row : Number(place)];
    const result = row?.results.get(frame);
    return result && role ? layerOf(key, row, result, role) : null;
  }

  #drawImages() {
    const row = this.#rows[this.#row];
    const result = row.results.get(this.#frame);
    const layers = this.#layerKeys.map((key) => this.#layer(key)).filter(Boolean);
    this.#view.element.hidden = layers.length === 0;
    const waits = ['queued', 'running'].includes(this.#run.status) || this.#run.stored_results > 0 && row.results.size === 0;
    this.#imageState.textContent = result ? '' : `Frame ${this.#frame} of ${row.label} is not there${waits ? ' yet' : ''}.`;
    this.#imageState.hidden = Boolean(result);
    this.#drawLayerList();
    if (layers.length > 0) this.#showLayers(layers);
    this.#drawChips();
    replace(this.#files, result && ['Files: ', Object.keys(result.images).sort((a, b) => rank(a) - rank(b)).map((role) =>
      h('a', {href: blobUrl(result.images[role]), download: fileName(this.#run.id, row.label, result, role)}, role.replaceAll('_', ' ')))]);
    replace(this.#details, result && [executionHistogram(result), counters(result)]);
  }

  // The two that are compared stay the same by their keys.
  #showLayers(layers) {
    const before = this.#view.layers;
    const {a, b} = this.#view.state;
    const index = (i) => {
      const kept = layers.findIndex(({key}) => key === before[i]?.key);
      return kept >= 0 ? kept : Math.min(i, layers.length - 1);
    };
    this.#view.setLayers(layers, before.length > 0 ? {a: index(a), b: index(b)} : {});
    const [, last] = this.#run.request.frames;
    const ahead = this.#playing ? framesAhead : 1;
    this.#view.settled.then(() => {
      for (let frame = this.#frame + 1; frame <= Math.min(last, this.#frame + ahead); ++frame) {
        this.#view.readAhead(this.#layerKeys.map((key) => this.#layer(key, frame)).filter(Boolean));
      }
    });
  }

  // What is looked at most, at one click.
  #drawChips() {
    const row = this.#rows[this.#row];
    const result = row.results.get(this.#frame);
    if (!result) return replace(this.#chips);
    const focused = this.#chips.contains(document.activeElement);
    const baseline = this.#baseline();
    const other = baseline && baseline !== row ? this.#rows.indexOf(baseline) : -1;
    const presets = [
      result.images.reference && {title: 'Image ⇔ reference', a: '*:image', b: '*:reference', share: 0.5},
      other >= 0 && {title: `Image ⇔ ${baseline.label}`, a: '*:image', b: `${other}:image`, share: 0.5},
      // The image lies behind the map: the line starts at the right edge and can be drawn over it.
      ...rolesOf(result).filter((role) => role !== 'image' && !role.startsWith('reference') && role !== 'hdr')
        .map((role) => ({title: roleTitle(role, row, result), a: `*:${role}`, b: '*:image', share: 1})),
      result.images.hdr && result.images.reference_hdr && {title: 'Linear images', a: '*:hdr', b: '*:reference_hdr', share: 0.5},
    ].filter(Boolean);
    const {mode, a, b} = this.#view.state;
    const [left, right] = [this.#view.layers[a]?.key, this.#view.layers[b]?.key];
    replace(this.#chips, presets.map((preset) => h('button.chip', {type: 'button', 'aria-pressed': String(mode === 'wipe' && preset.a === left && preset.b === right), onclick: () => this.#showPreset(preset)}, preset.title)));
    if (focused) this.#chips.querySelector('[aria-pressed="true"]')?.focus();
  }

  #showPreset({a, b, share}) {
    const keys = [...this.#layerKeys];
    for (const key of [a, b]) {
      if (keys.includes(key)) continue;
      if (keys.length === maxLayers) keys.splice(keys.findLastIndex((other) => other !== a && other !== b), 1);
      keys.push(key);
    }
    this.#setLayerKeys(keys);
    const at = (key) => Math.max(0, this.#view.layers.findIndex((layer) => layer.key === key));
    this.#view.change({mode: 'wipe', a: at(a), b: at(b), share});
    this.#draw();
  }

  #setLayerKeys(keys) {
    this.#layerKeys = keys;
    this.#address.set({layers: keys.join(',')});
    this.#drawImages();
  }

  // The layers in their order, with a control that adds one and buttons that take them away.
  #drawLayerList() {
    const row = (place) => this.#rows[place === '*' ? this.#row : Number(place)];
    const title = (key) => {
      const [place, role] = key.split(':');
      const result = row(place)?.results.get(this.#frame);
      return `${place === '*' ? 'selected technique' : row(place)?.label ?? 'no such technique'}: ${result ? roleTitle(role, row(place), result) : role}`;
    };
    const open = this.#layerList.querySelector('details')?.open ?? false;
    const chosen = this.#layerList.querySelector('select')?.value ?? '*';
    const what = h('select', {});
    const fill = (place) => {
      const result = row(place)?.results.get(this.#frame);
      replace(what, result ? rolesOf(result).map((role) => h('option', {value: role}, roleTitle(role, row(place), result))) : []);
    };
    const who = h('select', {onchange: () => fill(who.value)}, h('option', {value: '*'}, 'selected technique'), this.#rows.map(({label}, i) => h('option', {value: i, selected: String(i) === chosen}, label)));
    fill(chosen);
    const full = this.#layerKeys.length >= maxLayers;
    replace(this.#layerList, h('details', {open}, h('summary', {}, `Layers (${this.#layerKeys.length} of at most ${maxLayers})`),
      h('ol', {}, this.#layerKeys.map((key, i) => h('li', {}, title(key), this.#layerKeys.length > 1 && h('button.plain', {type: 'button', 'aria-label': `Take away layer ${i + 1}`,
        onclick: () => this.#setLayerKeys(this.#layerKeys.filter((_, other) => other !== i))}, '✕')))),
      h('div.layer-add', {}, field('of', who), field('layer', what), h('button', {type: 'button', disabled: full, onclick: () => {
        const key = `${who.value}:${what.value}`;
        if (what.value && !this.#layerKeys.includes(key)) this.#setLayerKeys([...this.#layerKeys, key]);
      }}, 'Add layer'))));
  }

  #report() {
    this.#address.write();
    const run = this.#run;
    const {groups, summary, note} = this.#figures();
    const [first, last] = run.request.frames;
    const labels = this.#view.layers.map(({label}, i) => `${i + 1} ${label}`).join(', ');
    saveReport(`run-${run.id}`, {
      title: `Run ${run.id}: ${run.capture.title || run.capture.name}`, address: location.href, facts: [...this.#factList(), ['frame', this.#frame]],
      table: tableMarkdown(groups, summary), note, picture: this.#view.pictureUrl(), caption: `Frame ${this.#frame}; ${this.#view.state.mode}; layers ${labels}`,
      plots: [{title: 'Measure against measure', svg: this.#scatter.text()}, ...(last > first ? [{title: `Over frames: ${this.#lines.title}`, svg: this.#lines.text()}] : [])],
    });
    announce('The report is saved');
  }
}

function fileName(run, label, result, role) {
  return `run${run}-${label.replace(/[^\w=.-]+/g, '_')}-frame${result.frame}-${role}.${/(hdr|_values)$/.test(role) ? 'exr' : 'png'}`;
}

function counters(result) {
  const entries = Object.entries(result.counters ?? {});
  return entries.length > 0 && h('table.counters', {}, h('caption', {}, 'Counters'),
    h('tbody', {}, entries.map(([name, value]) => h('tr', {}, h('th', {scope: 'row'}, name), h('td.number', {}, count(value))))));
}
