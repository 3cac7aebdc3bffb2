// What a run measures, as the table, the plots and the reports name it.
import {bytes, count, fixed, missing, scientific, shortCount, significant} from './format.js';

const mean = (values) => (values.length > 0 ? values.reduce((sum, value) => sum + value, 0) / values.length : NaN);

// Where a result has them.
const picks = {
  paper: (r) => r.memory.paper_bytes_per_pixel, fitted: (r) => r.memory.fitted_bytes_per_pixel, allocated: (r) => r.memory.allocated_bytes,
  executions: (r) => r.shading.executions, perPixel: (r) => r.shading.per_pixel_mean,
  total: (r) => r.ms.total, spread: (r) => r.spread, cold: (r) => r.ms.cold,
  mse: (r) => r.error.mse, flip: (r) => r.error.flip_mean, flicker: (r) => r.error.flicker,
};

/** A measure of one result, null where it was not measured. */
export const measured = (result, key) => picks[key](result) ?? null;

/** Means over frames of what is shown; `results` are of one technique. */
export function summarise(results) {
  const summary = {frames: results.length, passes: new Map(), fragments: new Map()};
  for (const key of Object.keys(picks)) summary[key] = mean(results.map((result) => measured(result, key)).filter((value) => value !== null));
  // The PSNR of the mean error, which is not the mean of the PSNRs.
  summary.psnr = summary.mse === 0 ? Infinity : -10 * Math.log10(summary.mse);
  const add = (map, name, value) => map.set(name, (map.get(name) ?? 0) + value / results.length);
  for (const result of results) {
    for (const [name, shaded] of Object.entries(result.shading.fragments ?? {})) add(summary.fragments, name, shaded);
    for (const name of result.ms.pass_order ?? Object.keys(result.ms.passes)) add(summary.passes, name, result.ms.passes[name]);
  }
  return summary;
}

/**
 * The measures: `of(summary)`, `text(value)`; `better` -1 where less is better, 1 where more is; `unit` as columns show it, `group` its
 * heading. `ratio` is to the baseline and has no summary of its own.
 */
export const measures = [
  {key: 'paper', title: 'Paper', unit: 'B/px', group: 'Memory', better: -1, hint: "the publication's own format", text: (v) => significant(v, 4)},
  {key: 'fitted', title: 'Fitted', unit: 'B/px', group: 'Memory', better: -1, hint: 'what our passes keep over the frame, lists and triangle numbers included', text: (v) => significant(v, 4)},
  {key: 'allocated', title: 'Allocated', unit: '', group: 'Memory', better: -1, hint: 'the same with the images that come out and the maps', text: (v) => bytes(Math.round(v))},
  {key: 'executions', title: 'Executions', unit: 'per frame', group: 'Lighting', better: -1, hint: 'lighting executions', text: shortCount, long: count},
  {key: 'perPixel', title: 'Mean', unit: 'per pixel', group: 'Lighting', better: -1, text: (v) => fixed(v, 2)},
  {key: 'total', title: 'Frame', unit: 'ms', group: 'Time', better: -1, hint: 'sum of the warm pass medians, and the spread of the repeats', text: (v) => fixed(v, 1)},
  {key: 'ratio', title: 'Ratio', unit: '', group: 'Time', better: -1, hint: 'to the baseline; only ratios travel between machines', text: (v) => (Number.isFinite(v) ? `${fixed(v, 2)}×` : missing)},
  {key: 'mse', title: 'MSE', unit: '', group: 'Error', better: -1, hint: 'on the sRGB image, against the reference', text: scientific},
  {key: 'psnr', title: 'PSNR', unit: 'dB', group: 'Error', better: 1, text: (v) => (v === Infinity ? '∞' : fixed(v, 2))},
  {key: 'flip', title: 'FLIP', unit: 'mean', group: 'Error', better: -1, hint: 'perceived difference, 0 to 1', text: (v) => fixed(v, 4)},
  {key: 'flicker', title: 'Flicker', unit: '', group: 'Error', better: -1, hint: 'what moves from frame to frame but not in the reference', text: scientific},
];

export const measureOf = (key) => measures.find((measure) => measure.key === key);

/** "Memory: Fitted, B/px": a measure by itself. */
export const measureTitle = ({group, title, unit}) => `${group}: ${title}${unit ? `, ${unit}` : ''}`;

/** The value of a row's measure; NaN where it is not measured. */
export function valueOf(row, key, baseline) {
  if (!row.summary) return NaN;
  return key === 'ratio' ? (baseline ? row.summary.total / baseline.total : NaN) : row.summary[key];
}

/** Which of the rows' times the others' are compared with: `msaa` with the run's samples, else any `msaa`. */
export function defaultBaseline(run, keys) {
  const candidates = keys.filter((key) => key.technique === 'msaa');
  return candidates.find((key) => key.parameters.samples === run.request.samples) ?? candidates.at(-1) ?? null;
}

/**
 * The best value of a measure over rows, and whether a row's is as good: "best", "within" (times whose spread of repeats
 * reaches the best's) or "".
 */
export function judge(rows, key, baseline) {
  const {better} = measureOf(key);
  const values = rows.map((row) => valueOf(row, key, baseline));
  const known = values.filter((value) => !Number.isNaN(value));
  if (known.every((value) => value === known[0])) return () => '';
  const best = better < 0 ? Math.min(...known) : Math.max(...known);
  const winner = rows[values.indexOf(best)].summary;
  const timed = key === 'total' || key === 'ratio';
  return (row) => {
    const value = valueOf(row, key, baseline);
    if (value === best) return 'best';
    const reached = timed && row.summary && row.summary.total - row.summary.spread / 2 <= winner.total + winner.spread / 2;
    return reached ? 'within' : '';
  };
}

/** The rows that no other beats in both measures, sorted by the first. */
export function paretoFront(rows, keyX, keyY, baseline) {
  const [signX, signY] = [-measureOf(keyX).better, -measureOf(keyY).better];
  const points = rows.map((row) => ({row, x: signX * valueOf(row, keyX, baseline), y: signY * valueOf(row, keyY, baseline)}))
    .filter(({x, y}) => !Number.isNaN(x) && !Number.isNaN(y)).sort((a, b) => a.x - b.x || a.y - b.y);
  const front = [];
  for (const point of points) if (front.length === 0 || point.y < front.at(-1).y) front.push(point);
  return front.map(({row}) => row);
}
