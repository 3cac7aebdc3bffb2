// What one frame's results say beside their figures: time by pass, lighting executions by pixel, counters.
import {h} from './dom.js';
import {count, fixed, missing, shortCount} from './format.js';

/** The passes of each technique as bars of one scale, with their times and fragments as text. */
export function passBars(rows) {
  const measured = rows.filter((row) => row.summary);
  if (measured.length === 0) return h('p.quiet', {}, 'Nothing is measured yet.');
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

export function counters(result) {
  const entries = Object.entries(result.counters ?? {});
  return entries.length > 0 && h('table.counters', {}, h('caption', {}, 'Counters'),
    h('tbody', {}, entries.map(([name, value]) => h('tr', {}, h('th', {scope: 'row'}, name), h('td.number', {}, count(value))))));
}
