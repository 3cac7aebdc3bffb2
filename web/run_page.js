// One run: its progress while it lasts, its figures, and its images against the reference.
import {blobUrl, followRun, get, loadPalettes, post, remove, techniques} from './api.js';
import {legend, scaleOf} from './colour_scales.js';
import {ComparisonView} from './comparison_view.js';
import {announce, field, h, replace} from './dom.js';
import {count, duration, fixed, techniqueLabel, when} from './format.js';
import {PixelStory} from './pixel_story.js';
import {advisor, costPlot} from './plots.js';
import {defaultBaseline, executionHistogram, passBars, resultsTable, summarise} from './results_table.js';
import {frameRange, runSize, statusPill} from './runs_page.js';

const roleTitles = {image: 'image', reference: 'reference', error: 'error', shading: 'shading', hdr: 'linear image (EXR)'};

export async function runPage(id) {
  const [run, registry] = await Promise.all([get(`/api/runs/${id}`), techniques(), loadPalettes()]);
  const page = new RunPage(run, registry);
  page.start();
  return {element: page.element, title: `Run ${id}`, close: () => page.close()};
}

class RunPage {
  #run;
  #registry;
  #rows;               // one for each technique of the request: {technique, parameters, label, entry, results: Map by frame}
  #frame;
  #overFrames = false; // the table shows means
  #row = 0;            // the technique whose images are shown
  #other = 0;          // the technique it is compared with
  #what = 'reference'; // the view: reference, technique, or a map's role
  #view = new ComparisonView();
  #story = new PixelStory();
  #stopFollowing = () => {};
  #lastWhat = null;    // the view drawn last
  #drawing = 0;
  #progress = h('div.progress', {});
  #facts = h('dl.facts.wide', {});
  #table = h('div', {});
  #passes = h('div', {});
  #plot;
  #advisor;
  #plotTimer = 0;
  #chips = h('div.chips', {role: 'group', 'aria-label': 'What is shown'});
  #legend = h('div', {});
  #files = h('p.files', {});
  #details = h('div.result-details', {});
  #slider = h('input', {type: 'range', step: 1, oninput: () => this.#setFrame(this.#slider.valueAsNumber)});
  #frameText = h('output.frame-number', {});
  #techniqueSelect = h('select', {onchange: () => this.#setRow(Number(this.#techniqueSelect.value))});
  #otherSelect = h('select', {onchange: () => {
    this.#other = Number(this.#otherSelect.value);
    this.#draw();
  }});
  #otherField = field('compared with', this.#otherSelect);

  constructor(run, registry) {
    this.#run = run;
    this.#registry = registry;
    this.#rows = run.request.techniques.map(({technique, parameters}) => {
      const entry = registry.find((candidate) => candidate.name === technique);
      return {technique, parameters, entry, label: techniqueLabel(technique, parameters, entry), results: new Map()};
    });
    const [first, last] = run.request.frames;
    this.#frame = first;
    this.#slider.setAttribute('min', first);
    this.#slider.setAttribute('max', last);
    this.#slider.value = first;
    const options = () => this.#rows.map(({label}, i) => h('option', {value: i}, label));
    replace(this.#techniqueSelect, options());
    replace(this.#otherSelect, options());
    this.#other = this.#rows.indexOf(defaultBaseline(run, this.#rows) ?? this.#rows[0]);
    this.#otherSelect.value = this.#other;
    // The most telling first view is of what is compared, not of the baselines.
    this.#row = Math.max(0, this.#rows.findLastIndex((row) => row.technique !== 'noaa'));
    this.#techniqueSelect.value = this.#row;
    this.#plot = costPlot(run.id);
    this.#advisor = advisor(run.id, registry);
    this.element = this.#build();
  }

  #build() {
    const run = this.#run;
    const title = run.capture.title || run.capture.name;
    const [first, last] = run.request.frames;
    const means = h('input', {type: 'checkbox', onchange: () => {
      this.#overFrames = means.checked;
      this.#draw();
    }});
    return h('section.run-page', {},
      h('p.crumbs', {}, h('a', {href: '#/runs'}, 'Runs'), ' / ', h('a', {href: `#/captures/${run.capture.hash}`}, title)),
      h('h1', {}, `Run ${run.id}`, h('span.quiet', {}, ` ${title}`)),
      this.#progress, this.#facts,
      h('div.section-head', {}, h('h2', {}, 'Figures'), last > first && h('label.check', {}, means, 'means over all frames'),
        h('span.spacer', {}),
        h('a.button', {href: `/api/runs/${run.id}/results.csv`, download: `run-${run.id}-results.csv`}, 'CSV'),
        h('a.button', {href: `/api/runs/${run.id}/results.json`, download: `run-${run.id}-results.json`}, 'JSON')),
      this.#table,
      h('details', {}, h('summary', {}, 'Time by pass'), this.#passes),
      run.request.reference_samples > 0 && [h('h2', {}, 'Cost against error'), this.#plot.element, h('h2', {}, 'Advisor'), this.#advisor.element],
      h('div.section-head', {}, h('h2', {}, 'Images'), h('div.field.frame', {},
        h('label', {}, 'Frame ', this.#frameText, this.#slider)),
      field('technique', this.#techniqueSelect), this.#otherField),
      this.#chips, this.#view.element, this.#story.element, this.#legend, this.#files, this.#details);
  }

  start() {
    this.#view.onpick = (pixel) => {
      const {technique, parameters} = this.#rows[this.#row];
      this.#story.show(this.#run, technique, parameters, this.#frame, pixel);
    };
    this.#showRun();
    this.#draw();
    this.#stopFollowing = followRun(this.#run.id, {
      result: ({ordinal, result}) => this.#take(ordinal, result),
      status: (status) => {
        Object.assign(this.#run, status);
        this.#showProgress();
      },
      end: (status) => this.#ended(status),
      lost: () => this.#progress.classList.add('lost'),
    });
  }

  close() {
    this.#stopFollowing();
    this.#view.close();
    clearTimeout(this.#plotTimer);
    cancelAnimationFrame(this.#drawing);
  }

  #take(ordinal, result) {
    this.#rows[ordinal].results.set(result.frame, result);
    if (!this.#run.head) this.#refreshHead();
    // Many results can come at once; one drawing for all of them.
    cancelAnimationFrame(this.#drawing);
    this.#drawing = requestAnimationFrame(() => this.#draw());
    this.#refreshPlot(1000);
  }

  // The service draws it anew from all results, so not for each of them.
  #refreshPlot(wait) {
    clearTimeout(this.#plotTimer);
    if (this.#run.request.reference_samples > 0) this.#plotTimer = setTimeout(() => this.#plot.refresh(), wait);
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
    this.#refreshPlot(0);
    // The form's first budget is one of FLIP.
    if (this.#rows.some((row) => [...row.results.values()].some((result) => Number.isFinite(result.error.flip_mean)))) this.#advisor.ask();
  }

  #showRun() {
    this.#showProgress();
    const {head, request} = this.#run;
    const facts = [
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
    replace(this.#facts, facts.map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value))));
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

  #setFrame(frame) {
    this.#frame = frame;
    this.#draw();
  }

  #setRow(row) {
    this.#row = row;
    this.#techniqueSelect.value = row;
    this.#draw();
  }

  #draw() {
    this.#frameText.textContent = `${this.#frame}`;
    const rows = this.#rows.map((row, i) => {
      const results = this.#overFrames ? [...row.results.values()] : [row.results.get(this.#frame)].filter(Boolean);
      return {label: row.label, select: i, selected: i === this.#row, summary: results.length > 0 ? summarise(results) : null};
    });
    const baseline = defaultBaseline(this.#run, this.#rows);
    const baselineRow = baseline && rows[this.#rows.indexOf(baseline)];
    const focused = this.#table.contains(document.activeElement) ? this.#row : -1;
    replace(this.#table, resultsTable(rows, baselineRow?.summary ?? null, (row) => this.#setRow(row)),
      baselineRow?.summary && h('p.quiet.note', {}, `Ratios are to ${baseline.label}${this.#overFrames ? ', means over the frames measured so far' : ` in frame ${this.#frame}`}.`));
    if (focused >= 0) this.#table.querySelectorAll('.row-select')[focused]?.focus();
    replace(this.#passes, passBars(rows));
    this.#drawImages();
  }

  // What the current result can show: [{what, title}].
  #choices(result) {
    const choices = [];
    if (result.images.reference) choices.push({what: 'reference', title: 'Image ⇔ reference'});
    choices.push({what: 'technique', title: this.#rows.length > 1 ? 'Image ⇔ other technique' : 'Image'});
    for (const role of Object.keys(result.images).sort((a, b) => rank(a) - rank(b))) {
      const scale = scaleOf(role, this.#rows[this.#row].entry, result);
      if (scale) choices.push({what: role, title: `${scale.title} map`});
    }
    return choices;
  }

  #drawImages() {
    const row = this.#rows[this.#row];
    const result = row.results.get(this.#frame);
    this.#view.element.hidden = !result?.images.image;
    this.#otherField.hidden = this.#what !== 'technique' || this.#rows.length < 2;
    if (!result?.images.image) {
      replace(this.#chips, h('p.quiet', {}, `Frame ${this.#frame} of ${row.label} is not there${this.#run.status === 'running' ? ' yet' : ''}.`));
      [this.#legend, this.#files, this.#details].forEach((part) => replace(part));
      return;
    }
    const choices = this.#choices(result);
    const shown = choices.find(({what}) => what === this.#what) ?? choices[0];
    replace(this.#chips, choices.map(({what, title}) =>
      h('button.chip', {type: 'button', 'aria-pressed': String(what === shown.what), onclick: () => {
        this.#what = what;
        this.#draw();
        this.#chips.querySelector('[aria-pressed="true"]')?.focus();
      }}, title)));
    this.#showSides(shown.what, row, result);
    replace(this.#files, 'Files: ', Object.keys(result.images).sort((a, b) => rank(a) - rank(b)).map((role) =>
      h('a', {href: blobUrl(result.images[role]), download: fileName(this.#run.id, row.label, result, role)}, roleTitles[role] ?? role)));
    replace(this.#details, executionHistogram(result), counters(result));
  }

  #showSides(what, row, result) {
    const image = {url: blobUrl(result.images.image), label: row.label};
    const scale = scaleOf(what, row.entry, result);
    replace(this.#legend, scale && legend(scale));
    if (scale) {
      // The image lies behind the map: the line starts at the right edge and can be drawn over it.
      this.#view.show({url: blobUrl(result.images[what]), label: `${row.label}: ${scale.title.toLowerCase()}`, scale}, image, this.#lastWhat === what ? null : 1);
    } else {
      const other = this.#rows[this.#other].results.get(this.#frame)?.images.image;
      const right = what === 'reference'
        ? {url: blobUrl(result.images.reference), label: 'reference'}
        : other && this.#other !== this.#row ? {url: blobUrl(other), label: this.#rows[this.#other].label} : null;
      const fromMap = this.#lastWhat !== null && this.#lastWhat !== 'reference' && this.#lastWhat !== 'technique';
      this.#view.show(image, right, fromMap ? 0.5 : null);
    }
    this.#lastWhat = what;
  }
}

const order = ['image', 'reference', 'error', 'shading'];
const rank = (role) => (order.includes(role) ? order.indexOf(role) : role === 'hdr' ? 99 : 10);

function fileName(run, label, result, role) {
  return `run${run}-${label.replace(/[^\w=.-]+/g, '_')}-frame${result.frame}-${role}.${role === 'hdr' ? 'exr' : 'png'}`;
}

function counters(result) {
  const entries = Object.entries(result.counters ?? {});
  return entries.length > 0 && h('table.counters', {}, h('caption', {}, 'Counters'),
    h('tbody', {}, entries.map(([name, value]) => h('tr', {}, h('th', {scope: 'row'}, name), h('td.number', {}, count(value))))));
}
