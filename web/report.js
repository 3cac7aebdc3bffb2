// A page by itself of what is on the screen: HTML with the pictures inside, that needs no network.
import {download} from './files.js';

const escaped = (text) => String(text).replace(/[&<>"]/g, (c) => ({'&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;'}[c]));

const style = `:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:1100px;padding:0 1rem}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;font-size:.88rem}th,td{border-bottom:1px solid #8886;padding:.3rem .6rem;text-align:right}
td{white-space:nowrap}th:first-child,td:first-child{text-align:left}.scroll{overflow-x:auto}img,svg{max-width:100%;height:auto}img{image-rendering:pixelated;border:1px solid #8886}
dl{display:grid;grid-template-columns:repeat(auto-fill,minmax(190px,1fr));gap:.5rem 1rem}dt{font-size:.8rem;opacity:.75}dd{margin:0;overflow-wrap:anywhere}`;

function tableHtml(markdown) {
  const cells = (line) => line.slice(2, -2).split(/(?<!\\) \| /).map((text) => escaped(text.replaceAll('\\|', '|').replace(/^\*\*|\*\*$/g, '')));
  const [head, , ...rows] = markdown.trim().split('\n');
  const row = (line, tag) => `<tr>${cells(line).map((text) => `<${tag}>${text}</${tag}>`).join('')}</tr>`;
  return `<div class="scroll"><table><thead>${row(head, 'th')}</thead><tbody>${rows.map((line) => row(line, 'td')).join('')}</tbody></table></div>`;
}

/**
 * @param {{title, address, facts: [name, text][], table: string, plots: {title, svg}[], picture: string|null, caption: string, note: string}} view
 *   `table` as Markdown, `picture` a data: URL
 */
export function reportHtml({title, address, facts, table, note, plots, picture, caption}) {
  // SVG that the page itself drew; its texts are escaped by the browser's serialiser.
  return `<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src data:"><title>${escaped(title)}</title><style>${style}</style></head><body>
<h1>${escaped(title)}</h1><p>Made ${escaped(new Date().toISOString())}. The view: <a href="${escaped(address)}">${escaped(address)}</a></p>
<dl>${facts.map(([name, text]) => `<div><dt>${escaped(name)}</dt><dd>${escaped(text)}</dd></div>`).join('')}</dl>
<h2>Figures</h2>${tableHtml(table)}<p>${escaped(note)}</p>
${picture ? `<h2>Images</h2><figure><img src="${picture}" alt="${escaped(caption)}"><figcaption>${escaped(caption)}</figcaption></figure>` : ''}
${plots.map((plot) => `<h2>${escaped(plot.title)}</h2>${plot.svg}`).join('\n')}
</body></html>`;
}

export const saveReport = (name, view) => download(`${name}.html`, 'text/html', reportHtml(view));
