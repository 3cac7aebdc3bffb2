// A page by itself of what is on the screen: HTML with the pictures inside, that needs no network and has no script.
import {announce} from './dom.js';
import {download} from './files.js';

const escaped = (text) => String(text).replace(/[&<>"]/g, (c) => ({'&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;'}[c]));

const style = `:root{color-scheme:light dark;--line:#8886;--raised:#8883;--quiet:#888;--ink:CanvasText;--bad:#c0392b;--accent:#2f7fd0}
body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:1100px;padding:0 1rem}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.88rem}th,td{border-bottom:1px solid var(--line);padding:.3rem .6rem;text-align:left}
.figures th,.figures td,.number{text-align:right}.figures td{white-space:nowrap}.figures th:first-child,.figures td:first-child{text-align:left}caption{text-align:left;font-weight:600}
.scroll{overflow-x:auto}img,svg{max-width:100%;height:auto}img{image-rendering:pixelated;border:1px solid var(--line)}figure{margin:1rem 0}
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(190px,1fr));gap:.5rem 1rem}dt{font-size:.8rem;opacity:.75}dd{margin:0;overflow-wrap:anywhere}
.quiet{opacity:.75;font-weight:normal}.swatch,.key{display:inline-block;width:.9em;height:.9em;margin-right:.4em;vertical-align:-.1em}
.mask-picture{width:1.4rem;height:1.4rem;vertical-align:-.4rem;margin-right:.3rem}.pattern{width:12rem;flex:none}.pixel{fill:var(--raised);stroke:var(--quiet);stroke-width:.01}
.place{stroke:var(--quiet);stroke-width:.008}.mask-picture .place{fill:var(--line)}.sample-number{font-size:.075px;fill:var(--ink)}
.story-body,.pictures,.film-strip,.worst,.luma,.frame-parts{display:flex;flex-wrap:wrap;gap:1rem;align-items:start}.worst{gap:.4rem;list-style:none;padding:0}.worst li{font-size:.75rem}.worst img{width:72px}
.pictures figure{flex:1 1 240px;margin:0}.steps{display:inline-flex;align-items:flex-end;height:1.6rem;gap:1px}.steps i{width:5px;background:var(--accent)}
.legend-bar{height:16px}.legend-ticks{position:relative;height:1.3rem;font-size:.8rem}.legend-ticks span{position:absolute;transform:translateX(-50%)}
.pass-bar{display:flex;height:1rem;margin:.2rem 0}.pass-list{display:flex;flex-wrap:wrap;gap:.1rem 1rem;font-size:.84rem}.pass-bars{list-style:none;padding:0}
.pass-0{background:#0072b2}.pass-1{background:#e69f00}.pass-2{background:#009e73}.pass-3{background:#cc79a7}.pass-4{background:#56b4e9}.pass-5{background:#d55e00}.pass-6{background:#b8a800}.pass-7{background:#7a7a7a}
.against,.problem,.failed{color:var(--bad)}.bar{height:.8rem;background:var(--accent)}.bar-cell{width:240px}`;

/** A table of Markdown, as results_table.js writes it. */
export function tableHtml(markdown) {
  const cells = (line) => line.slice(2, -2).split(/(?<!\\) \| /).map((text) => escaped(text.replaceAll('\\|', '|').replace(/^\*\*|\*\*$/g, '')));
  const [head, , ...rows] = markdown.trim().split('\n');
  const row = (line, tag) => `<tr>${cells(line).map((text) => `<${tag}>${text}</${tag}>`).join('')}</tr>`;
  return `<div class="scroll"><table class="figures"><thead>${row(head, 'th')}</thead><tbody>${rows.map((line) => row(line, 'td')).join('')}</tbody></table></div>`;
}

function pictureOf(source) {
  const [width, height] = source.tagName === 'IMG' ? [source.naturalWidth, source.naturalHeight] : [source.width, source.height];
  const canvas = Object.assign(document.createElement('canvas'), {width, height});
  if (width > 0 && height > 0) canvas.getContext('2d').drawImage(source, 0, 0);
  return Object.assign(document.createElement('img'), {src: canvas.toDataURL('image/png'), alt: source.getAttribute('alt') ?? source.getAttribute('aria-label') ?? ''});
}

// Buttons that show something, and are not only pressed.
const telling = '.place, .fold, .row-select, .draw, .film-frame, .cell';

/** What of an element is seen, as HTML: canvases and images as pictures, no controls, nothing that is hidden or closed. */
export function printed(element) {
  if (element.matches('canvas, img')) return pictureOf(element).outerHTML;
  const copy = element.cloneNode(true);
  const [sources, places] = [element, copy].map((tree) => [...tree.querySelectorAll('canvas, img')]);
  places.forEach((place, i) => place.replaceWith(pictureOf(sources[i])));
  copy.querySelectorAll('[hidden], input, select, output, form, progress, label, .no-report').forEach((part) => part.remove());
  copy.querySelectorAll('details:not([open])').forEach((part) => part.remove());
  copy.querySelectorAll('button').forEach((button) => {
    if (!button.matches(telling)) return button.remove();
    const text = Object.assign(document.createElement('span'), {className: button.className});
    text.append(...button.childNodes);
    button.replaceWith(text);
  });
  copy.querySelectorAll('[href]').forEach((link) => (link.closest('svg') ? link.removeAttribute('href') : link.setAttribute('href', link.href)));
  copy.querySelectorAll('[tabindex], [id]').forEach((part) => ['tabindex', 'id'].forEach((name) => part.removeAttribute(name)));
  return copy.outerHTML;
}

/**
 * @param {{title, address, facts: [name, text][], parts: {title, html}[]}} view  `html` of tableHtml(), printed() or an SVG that the page
 *   drew; their texts are escaped by the browser's serialiser
 */
export function reportHtml({title, address, facts = [], parts}) {
  return `<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:"><title>${escaped(title)}</title><style>${style}</style></head><body>
<h1>${escaped(title)}</h1><p>Made ${escaped(new Date().toISOString())}. The view: <a href="${escaped(address)}">${escaped(address)}</a></p>
${facts.length > 0 ? `<dl>${facts.map(([name, text]) => `<div><dt>${escaped(name)}</dt><dd>${escaped(text)}</dd></div>`).join('')}</dl>` : ''}
${parts.map((part) => `${part.title ? `<h2>${escaped(part.title)}</h2>` : ''}${part.html}`).join('\n')}
</body></html>`;
}

export function saveReport(name, view) {
  download(`${name}.html`, 'text/html', reportHtml(view));
  announce('The report is saved');
}

/** The picture of a view with what is said of it, as a part of a report; null where nothing is shown. */
export function picturePart(view, caption) {
  const picture = view.pictureUrl();
  return picture && {title: 'Images', html: `<figure><img src="${picture}" alt="${escaped(caption)}"><figcaption>${escaped(caption)}</figcaption></figure>`};
}

/** What of a view's panels is open: legends, the box's figures, the list of the worst places. */
export const panelParts = (view) => view.panels.filter((panel) => panel.hasChildNodes()).map((panel) => ({html: printed(panel)}));
