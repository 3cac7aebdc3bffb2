// Cost against error of all settings of a run, and the advisor. The service draws and decides (replay/results/plots.hpp,
// advisor.hpp), so that the page says what the command line says.
import {get} from './api.js';
import {field, h, replace} from './dom.js';
import {fixed, scientific, significant, techniqueLabel} from './format.js';

const costs = [['time', 'ms'], ['ratio', 'ratio to msaa'], ['memory', 'memory']];
const errors = [['mse', 'MSE'], ['flip', 'FLIP']];

/** Returns {element, refresh}: refresh() draws what is measured by now. */
export function costPlot(run) {
  let [cost, error] = [costs[0][0], errors[0][0]];
  let turn = 0;
  const drawing = h('div.plot', {});
  const chips = h('div.choices', {});
  const link = h('a.button', {download: ''}, 'SVG');
  const path = () => `/api/runs/${run}/plot.svg?cost=${cost}&error=${error}`;
  function drawChips() {
    const group = (name, choices, chosen, choose) => h('div.chips', {role: 'group', 'aria-label': name}, choices.map(([value, title]) =>
      h('button.chip', {type: 'button', 'aria-pressed': String(value === chosen), onclick: () => {
        choose(value);
        drawChips();
        refresh();
      }}, title)));
    replace(chips, group('Cost', costs, cost, (value) => {
      cost = value;
    }), 'against', group('Error', errors, error, (value) => {
      error = value;
    }), h('span.spacer', {}), link,
    h('a.button', {href: `/api/runs/${run}/points.csv`, download: `run-${run}-points.csv`}, 'Points as CSV'),
    h('a.button', {href: `/api/runs/${run}/points.md`, download: `run-${run}-points.md`}, 'Points as Markdown'));
    link.setAttribute('href', path());
    link.setAttribute('download', `run-${run}-${cost}-${error}.svg`);
  }
  async function refresh() {
    const mine = ++turn;
    const response = await fetch(path()).catch(() => null);
    const text = response?.ok ? await response.text() : '';
    if (mine !== turn) return;
    const svg = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;
    if (svg.localName !== 'svg') return replace(drawing, h('p.quiet', {}, 'The plot could not be fetched.'));
    drawing.dataset.drawn = `${cost} ${error}`;
    replace(drawing, document.importNode(svg, true));
  }
  drawChips();
  return {element: h('div', {}, chips, drawing), refresh};
}

const titles = {memory: 'Least memory', time: 'Least time', both: 'Least memory × time'};

/** The form for a budget and the advice under it. */
export function advisor(run, registry) {
  const flip = h('input', {type: 'number', min: 0, step: 'any', value: 0.05});
  const mse = h('input', {type: 'number', min: 0, step: 'any'});
  const answer = h('div', {'aria-live': 'polite'});
  const label = ({technique, parameters}) => techniqueLabel(technique, parameters, registry.find((entry) => entry.name === technique));
  const costsText = (summary) => `${significant(summary.fitted_bytes_per_pixel, 4)} B/px, ${fixed(summary.total_ms, 1)} ms, worst frame: FLIP ${fixed(summary.worst_flip ?? NaN, 4)}, MSE ${scientific(summary.worst_mse ?? NaN)}`;
  async function ask(event) {
    event?.preventDefault();
    const query = new URLSearchParams();
    if (flip.value !== '') query.set('max_flip', flip.value);
    if (mse.value !== '') query.set('max_mse', mse.value);
    try {
      const advice = await get(`/api/runs/${run}/advice?${query}`);
      replace(answer, h('p.quiet.note', {}, `${advice.within} of ${advice.measured} measured settings are within the budget.`),
        advice.closest && h('p', {}, 'Closest: ', h('strong', {}, label(advice.closest)), ` (${costsText(advice.closest)}).`),
        h('ul.advice', {}, advice.choices.map(({cost, best, runner_up: second, reason}) => h('li', {},
          h('h3', {}, titles[cost]), h('strong', {}, label(best)), h('p.quiet', {}, costsText(best)),
          h('p', {}, second ? ['Then ', h('span.label', {}, label(second)), ` ${costsText(second)}`] : 'Nothing else measured is within the budget.'),
          h('details', {}, h('summary', {}, 'Reason'), h('p', {}, reason))))));
    } catch (error) {
      replace(answer, h('p.problem', {role: 'alert'}, error.message));
    }
  }
  const form = h('form.budget', {onsubmit: ask, 'aria-label': 'Error budget'},
    field('FLIP, mean', flip, 'largest of any frame; empty: any'), field('MSE', mse, 'largest of any frame; empty: any'),
    h('button', {type: 'submit'}, 'Advise'));
  return {element: h('div', {}, form, answer), ask};
}
