// The measured figures of one frame, or their means over all frames: one row for each technique, sorted, filtered, grouped.
import {h} from './dom.js';
import {count, fixed, missing, shortCount} from './format.js';
import {judge, measures, valueOf} from './measures.js';

/** The rows as they are shown: [{title, rows}], one group without a title when they are not grouped. */
export function arrange(rows, {sort, descending, filter, group}, baseline) {
  const words = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const kept = rows.filter((row) => words.every((word) => row.label.toLowerCase().includes(word)));
  if (sort) {
    const sign = descending ? -1 : 1;
    const values = new Map(kept.map((row) => [row, sort === 'label' ? row.label : valueOf(row, sort, baseline)]));
    const missingLast = (v) => (Number.isNaN(v) ? 1 : 0);
    kept.sort((p, q) => {
      const [a, b] = [values.get(p), values.get(q)];
      if (sort === 'label') return sign * a.localeCompare(b, 'en', {numeric: true});
      return missingLast(a) - missingLast(b) || sign * (a === b ? 0 : a < b ? -1 : 1) || 0;
    });
  }
  if (!group) return [{title: '', rows: kept}];
  const groups = new Map();
  for (const row of kept) groups.set(row[group], [...(groups.get(row[group]) ?? []), row]);
  return [...groups].map(([title, members]) => ({title: group === 'run' ? `Run ${title}` : title, rows: members}));
}

function groupRow() {
  const cells = [h('td', {})];
  for (let i = 0; i < measures.length;) {
    let span = 1;
    while (measures[i + span]?.group === measures[i].group) ++span;
    cells.push(h('th.group', {scope: 'colgroup', colspan: span}, measures[i].group));
    i += span;
  }
  return h('tr', {}, cells);
}

const marks = {best: ['●', 'best'], within: ['≈', 'within the spread of the best']};

/**
 * @param groups of arrange()
 * @param baseline the summary all times are divided by, or null
 * @param order {sort, descending}
 * @param on {select(row), sort(key)}
 */
export function resultsTable(groups, baseline, order, on) {
  const rows = groups.flatMap((group) => group.rows);
  const judges = measures.map(({key}) => judge(rows, key, baseline));
  const largest = measures.map(({key}) => Math.max(...rows.map((row) => valueOf(row, key, baseline)).filter((v) => Number.isFinite(v)), 0));
  const heading = (key, title, unit, hint, number) => {
    const active = order.sort === key;
    return h(number ? 'th.number' : 'th', {scope: 'col', title: hint, 'aria-sort': active ? (order.descending ? 'descending' : 'ascending') : null},
      h('button.sort', {type: 'button', 'data-sort': key, onclick: () => on.sort(key)}, title, unit && h('small', {}, ` ${unit}`), h('span.arrow', {'aria-hidden': true}, active ? (order.descending ? ' ▼' : ' ▲') : '')));
  };
  return h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'Figures'}, h('table.results', {}, h('thead', {}, groupRow(), h('tr', {},
    heading('label', 'Technique', '', '', false), measures.map(({key, title, unit, hint}) => heading(key, title, unit, hint, true)))),
  groups.map((group) => h('tbody', {}, group.title && h('tr.group-title', {}, h('th', {scope: 'rowgroup', colspan: measures.length + 1}, group.title)),
    group.rows.map((row) => h('tr', {class: row.selected ? 'selected' : ''},
      h('th', {scope: 'row'}, h('button.row-select', {type: 'button', 'aria-pressed': String(row.selected), 'data-row': row.select, onclick: () => on.select(row.select)}, row.label)),
      row.summary ? measures.map((measure, i) => cell(row, measure, valueOf(row, measure.key, baseline), largest[i], judges[i](row)))
        : h('td.quiet', {colspan: measures.length}, 'not measured yet')))))));
}

function cell(row, measure, value, largest, verdict) {
  const bar = h('i.cell-bar', {'aria-hidden': true});
  bar.style.width = `${largest > 0 && Number.isFinite(value) ? (100 * value) / largest : 0}%`;
  const [mark, words] = marks[verdict] ?? [];
  const spread = measure.key === 'total' && h('small', {}, ` ± ${fixed(row.summary.spread / 2, 1)}`);
  return h('td.number', {class: verdict, title: measure.long?.(value)},
    h('span.cell-text', {}, mark && h('span.mark', {title: words}, h('span', {'aria-hidden': true}, mark), h('span.visually-hidden', {}, ` ${words} `)), Number.isNaN(value) ? missing : measure.text(value), spread), bar);
}

/** The table as Markdown. */
export function tableMarkdown(groups, baseline) {
  const line = (cells) => `| ${cells.map((text) => String(text).replaceAll('|', '\\|')).join(' | ')} |`;
  const head = ['Technique', ...measures.map(({group, title, unit}) => `${group}: ${title}${unit ? ` (${unit})` : ''}`)];
  const body = groups.flatMap(({title, rows}) => [...(title ? [line([`**${title}**`, ...measures.map(() => '')])] : []),
    ...rows.map((row) => line([row.label, ...measures.map((measure) => {
      const value = valueOf(row, measure.key, baseline);
      return Number.isNaN(value) ? missing : measure.text(value);
    })]))]);
  return [line(head), line(['---', ...measures.map(() => '---:')]), ...body].join('\n') + '\n';
}

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
