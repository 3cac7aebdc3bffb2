// The measured figures of one frame, or their means over all frames: one row for each technique, sorted, filtered, grouped.
import {h, replace, setAttribute, setText} from './dom.js';
import {fixed, missing} from './format.js';
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

const marks = {best: ['●', 'best'], within: ['≈', 'within the spread of the best']};

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

// A figure with its mark and bar. Frames follow each other in the same cells: only what changes is touched.
class Cell {
  #measure;
  #mark = h('span', {});
  #text = document.createTextNode('');
  #spread = h('small', {});
  #bar = h('i.cell-bar', {'aria-hidden': true});
  #verdict = '';
  #width = '';

  constructor(measure) {
    this.#measure = measure;
    this.element = h('td.number', {}, h('span.cell-text', {}, this.#mark, this.#text, measure.key === 'total' && this.#spread), this.#bar);
  }

  draw(row, value, largest, verdict) {
    const text = Number.isNaN(value) ? missing : this.#measure.text(value);
    if (this.#text.data !== text) this.#text.data = text;
    if (this.#measure.key === 'total') setText(this.#spread, ` ± ${fixed(row.summary.spread / 2, 1)}`);
    const width = `${largest > 0 && Number.isFinite(value) ? (100 * value) / largest : 0}%`;
    if (this.#width !== width) this.#bar.style.width = this.#width = width;
    if (this.#measure.long) setAttribute(this.element, 'title', this.#measure.long(value));
    if (this.#verdict === verdict) return;
    this.#verdict = verdict;
    this.element.className = verdict ? `number ${verdict}` : 'number';
    const [mark, words] = marks[verdict] ?? [];
    replace(this.#mark, mark && h('span.mark', {title: words}, h('span', {'aria-hidden': true}, mark), h('span.visually-hidden', {}, ` ${words} `)));
  }
}

// A technique's line.
class Line {
  #select = h('button.row-select', {type: 'button'});
  #head = h('th', {scope: 'row'}, this.#select);
  #cells = null;

  constructor(select) {
    this.element = h('tr', {}, this.#head);
    this.#select.addEventListener('click', select);
  }

  draw(row, baseline, largest, judges) {
    setText(this.#select, row.label);
    this.#select.dataset.row = row.select;
    setAttribute(this.#select, 'aria-pressed', String(row.selected));
    this.element.classList.toggle('selected', row.selected);
    if (Boolean(this.#cells) !== Boolean(row.summary) || this.element.childElementCount === 1) {
      this.#cells = row.summary ? measures.map((measure) => new Cell(measure)) : null;
      this.element.replaceChildren(this.#head, ...(this.#cells?.map(({element}) => element) ?? [h('td.quiet', {colspan: measures.length}, 'not measured yet')]));
    }
    this.#cells?.forEach((cell, i) => cell.draw(row, valueOf(row, measures[i].key, baseline), largest[i], judges[i](row)));
  }
}

export class ResultsTable {
  #on;
  #headings = new Map();  // key -> {element, arrow}
  #lines = new Map();     // a row's `select` -> Line
  #table;
  #arranged = '';         // which lines lie where

  /** `on`: {select(row), sort(key)} */
  constructor(on) {
    this.#on = on;
    this.#table = h('table.results', {}, h('thead', {}, groupRow(), h('tr', {}, this.#heading('label', 'Technique', '', '', 'th'),
      measures.map(({key, title, unit, hint}) => this.#heading(key, title, unit, hint, 'th.number')))));
    this.element = h('div.scroll', {tabindex: 0, role: 'region', 'aria-label': 'Figures'}, this.#table);
  }

  #heading(key, title, unit, hint, tag) {
    const arrow = h('span.arrow', {'aria-hidden': true});
    const element = h(tag, {scope: 'col', title: hint}, h('button.sort', {type: 'button', 'data-sort': key, onclick: () => this.#on.sort(key)}, title, unit && h('small', {}, ` ${unit}`), arrow));
    this.#headings.set(key, {element, arrow});
    return element;
  }

  /**
   * @param groups of arrange()
   * @param baseline the summary all times are divided by, or null
   * @param order {sort, descending}
   */
  draw(groups, baseline, {sort, descending}) {
    for (const [key, {element, arrow}] of this.#headings) {
      setAttribute(element, 'aria-sort', key !== sort ? null : descending ? 'descending' : 'ascending');
      setText(arrow, key !== sort ? '' : descending ? ' ▼' : ' ▲');
    }
    const rows = groups.flatMap((group) => group.rows);
    const judges = measures.map(({key}) => judge(rows, key, baseline));
    const largest = measures.map(({key}) => Math.max(...rows.map((row) => valueOf(row, key, baseline)).filter((v) => Number.isFinite(v)), 0));
    for (const row of rows) {
      if (!this.#lines.has(row.select)) this.#lines.set(row.select, new Line(() => this.#on.select(row.select)));
      this.#lines.get(row.select).draw(row, baseline, largest, judges);
    }
    this.#arrange(groups);
  }

  #arrange(groups) {
    const arranged = JSON.stringify(groups.map(({title, rows}) => [title, rows.map(({select}) => select)]));
    if (arranged === this.#arranged) return;
    this.#arranged = arranged;
    const focused = this.element.contains(document.activeElement) ? document.activeElement : null;
    this.#table.replaceChildren(this.#table.tHead, ...groups.map(({title, rows}) => h('tbody', {},
      title && h('tr.group-title', {}, h('th', {scope: 'rowgroup', colspan: measures.length + 1}, title)), rows.map(({select}) => this.#lines.get(select).element))));
    if (focused?.isConnected) focused.focus({preventScroll: true});
  }
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
