// The rows of a run's table: one for each technique of its request, with the results that have come, by frame.
import {techniqueLabel} from './format.js';
import {defaultBaseline, summarise} from './measures.js';

/** Rows {technique, parameters, entry, run, label, results: Map by frame}; those of another run than the page's, not `own`, say so. */
export function rowsOf(run, registry, own) {
  return run.request.techniques.map(({technique, parameters}) => {
    const entry = registry.find((candidate) => candidate.name === technique);
    const label = techniqueLabel(technique, parameters, entry);
    return {technique, parameters, entry, run: run.id, label: own ? label : `${label} (run ${run.id})`, results: new Map()};
  });
}

/** Puts a run's results into its rows. */
export function takeResults(rows, results) {
  const same = (row, result) => row.technique === result.technique && Object.entries(row.parameters).every(([name, value]) => result.parameters[name] === value);
  for (const result of results) rows.find((row) => same(row, result))?.results.set(result.frame, result);
}

/** The row all times are compared with: one of this run. */
export const baselineOf = (run, rows) => defaultBaseline(run, rows.filter((row) => row.run === run.id));

/** The rows as the table and the plots take them: figures of a frame, or means when `frame` is null. */
export function figuresOf(rows, selected, frame) {
  const families = [...new Set(rows.map(({technique}) => technique))];
  return rows.map((row, i) => {
    const results = frame === null ? [...row.results.values()] : [row.results.get(frame)].filter(Boolean);
    return {label: row.label, technique: row.technique, family: families.indexOf(row.technique), run: row.run, select: i, selected: i === selected, summary: results.length > 0 ? summarise(results) : null};
  });
}
