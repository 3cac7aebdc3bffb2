// The measured figures of one frame, or their means over all frames: one row for each technique.
import {h} from './dom.js';
import {bytes, count, fixed, missing, scientific, shortCount, significant} from './format.js';

/** Which of the run's techniques the others' times are compared with: `msaa` with the run's samples, else any `msaa`. */
export function defaultBaseline(run, keys) {
  const candidates = keys.filter((key) => key.technique === 'msaa');
  return candidates.find((key) => key.parameters.samples === run.request.samples) ?? candidates.at(-1) ?? null;
}

const mean = (values) => (values.length > 0 ? values.reduce((sum, value) => sum + value, 0) / values.length : NaN);

/** Means over frames of what the table shows; `results` are of one technique. */
export function summarise(results) {
  const of = (pick) => mean(results.map(pick).filter((value) => value !== null && value !== undefined));
  const mse = of((r) => r.error.mse);
  const passes = new Map();
  const fragments = new Map();
  for (const result of results) {
    for (const [name, shaded] of Object.entries(result.shading.fragments ?? {})) {
      fragments.set(name, (fragments.get(name) ?? 0) + shaded / results.length);
    }
    for (const name of result.ms.pass_order ?? Object.keys(result.ms.passes)) {
      passes.set(name, (passes.get(name) ?? 0) + result.ms.passes[name] / results.length);
    }
  }
  return {
    frames: results.length,
    paper: of((r) => r.memory.paper_bytes_per_pixel), fitted: of((r) => r.memory.fitted_bytes_per_pixel),
    allocated: of((r) => r.memory.allocated_bytes),
    executions: of((r) => r.shading.executions), perPixel: of((r) => r.shading.per_pixel_mean),
    total: of((r) => r.ms.total), spread: of((r) => r.spread), cold: of((r) => r.ms.cold),
    // The PSNR of the mean error, which is not the mean of the PSNRs.
    mse, psnr: mse === 0 ? Infinity : -10 * Math.log10(mse),
    flip: of((r) => r.error.flip_mean),
    passes, fragments,
  };
}

const columns = [
  {title: 'Technique', head: true},
  {title: 'Paper', unit: 'B/px', group: 'Memory', hint: "the publication's own format"},
  {title: 'Fitted', unit: 'B/px', group: 'Memory', hint: 'what our passes keep over the frame, lists and triangle numbers included'},
  {title: 'Allocated', unit: '', group: 'Memory', hint: 'the same with the images that come out and the maps'},
  {title: 'Executions', unit: 'per frame', group: 'Lighting', hint: 'lighting executions'},
  {title: 'Mean', unit: 'per pixel', group: 'Lighting'},
  {title: 'Frame', unit: 'ms', group: 'Time', hint: 'sum of the warm pass medians, and the spread of the repeats'},
  {title: 'Ratio', unit: '', group: 'Time', hint: 'to the baseline; only ratios travel between machines'},
  {title: 'MSE', unit: '', group: 'Error', hint: 'on the sRGB image, against the reference'},
  {title: 'PSNR', unit: 'dB', group: 'Error'},
  {title: 'FLIP', unit: 'mean', group: 'Error', hint: 'perceived difference, 0 to 1'},
];

function groupRow() {
  const cells = [h('td', {})];
  for (let i = 1; i < columns.length;) {
    let span = 1;
    while (columns[i + span]?.group === columns[i].group) ++span;
    cells.push(h('th.group', {scope: 'colgroup', colspan: span}, columns[i].group));
    i += span;
  }
  return h('tr', {}, cells);
}

/**
 * @param rows [{key, label, summary|null, selected, colour}]
 * @param baseline the summary all times are divided by, or null
 */
export function resultsTable(rows, baseline, onSelect) {
  const bestMse = Math.min(...rows.map((row) => row.summary?.mse ?? Infinity).filter((value) => !Number.isNaN(value)));
  return h('div.scroll', {}, h('table.results', {}, h('thead', {}, groupRow(), h('tr', {}, columns.map((column) =>
    h(column.head ? 'th' : 'th.number', {scope: 'col', title: column.hint}, column.title, column.unit && h('small', {}, ` ${column.unit}`))))),
  h('tbody', {}, rows.map(({label, summary, selected, select}) => h('tr', {class: selected ? 'selected' : ''},
    h('th', {scope: 'row'}, h('button.row-select', {type: 'button', 'aria-pressed': String(selected), onclick: () => onSelect(select)}, label)),
    summary ? cells(summary, baseline, bestMse) : h('td.quiet', {colspan: columns.length - 1}, 'not measured yet'))))));
}

function cells(s, baseline, bestMse) {
  const ratio = baseline ? s.total / baseline.total : NaN;
  return [
    h('td.number', {}, significant(s.paper, 4)), h('td.number', {}, significant(s.fitted, 4)), h('td.number', {}, bytes(Math.round(s.allocated))),
    h('td.number', {title: count(s.executions)}, shortCount(s.executions)), h('td.number', {}, fixed(s.perPixel, 2)),
    h('td.number', {}, fixed(s.total, 1), h('small', {}, ` ± ${fixed(s.spread / 2, 1)}`)),
    h('td.number', {}, Number.isFinite(ratio) ? `${fixed(ratio, 2)}×` : missing),
    h('td.number', {class: s.mse === bestMse ? 'best' : ''}, scientific(s.mse)),
    h('td.number', {}, s.psnr === Infinity ? '∞' : fixed(s.psnr, 2)),
    h('td.number', {}, fixed(s.flip, 4)),
  ];
}

/** The passes of each technique as bars of one scale, with their times and fragments as text. */
export function passBars(rows) {
  const measured = rows.filter((row) => row.summary);
  const longest = Math.max(...measured.map((row) => row.summary.total), 1e-9);
  return h('ul.pass-bars', {}, measured.map(({label, summary}) => {
    const bar = h('div.pass-bar', {});
    const list = h('div.pass-list', {});
    [...summary.passes].forEach(([name, ms], i) => {
      const part = h('span', {class: `pass-${i % 8}`, title: `${name}: ${fixed(ms, 2)} ms`});
      part.style.width = `${(100 * ms) / longest}%`;
      bar.append(part);
      list.append(h('span', {}, h('i', {class: `key pass-${i % 8}`}), name, ' ', h('b', {}, fixed(ms, 2)),
        summary.fragments.has(name) && h('span.quiet', {title: 'fragments shaded in a frame'}, ` ${shortCount(summary.fragments.get(name))} fragments`)));
    });
    return h('li', {}, h('div.pass-title', {}, label, ' ', h('span.quiet', {}, `${fixed(summary.total, 1)} ms`)), bar, list);
  }));
}

/** How many pixels took how many lighting executions. */
export function executionHistogram(result) {
  const histogram = result.shading.histogram;
  const most = Math.max(...histogram, 1);
  const total = histogram.reduce((sum, value) => sum + value, 0);
  const last = histogram.findLastIndex((value) => value > 0);
  return h('table.histogram', {}, h('caption', {}, 'Lighting executions per pixel'),
    h('tbody', {}, histogram.slice(0, last + 1).map((value, executions) => {
      const bar = h('div.bar', {});
      bar.style.width = `${(100 * value) / most}%`;
      return h('tr', {}, h('th', {scope: 'row'}, executions), h('td.bar-cell', {}, bar),
        h('td.number', {title: `${count(value)} pixels`}, total > 0 ? `${fixed((100 * value) / total, 1)} %` : missing));
    })));
}
