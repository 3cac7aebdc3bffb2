// The advisor: the service decides (replay/results/advisor.hpp), so that the page says what the command line says.
import {get} from './api.js';
import {field, h, replace} from './dom.js';
import {fixed, scientific, significant, techniqueLabel} from './format.js';

const titles = {memory: 'Least memory', time: 'Least time', both: 'Least memory × time'};

/** The form for a budget and the advice under it. */
export function advisor(run, registry) {
  const flip = h('input', {type: 'number', min: 0, step: 'any', value: 0.05});
  const mse = h('input', {type: 'number', min: 0, step: 'any'});
  const answer = h('div', {'aria-live': 'polite'});
  let turn = 0;  // of the last question: an earlier one's answer may come later
  const label = ({technique, parameters}) => techniqueLabel(technique, parameters, registry.find((entry) => entry.name === technique));
  const costsText = (summary) => `${significant(summary.fitted_bytes_per_pixel, 4)} B/px, ${fixed(summary.total_ms, 1)} ms, worst frame: FLIP ${fixed(summary.worst_flip ?? NaN, 4)}, MSE ${scientific(summary.worst_mse ?? NaN)}`;
  async function ask(event) {
    event?.preventDefault();
    const mine = ++turn;
    const query = new URLSearchParams();
    if (flip.value !== '') query.set('max_flip', flip.value);
    if (mse.value !== '') query.set('max_mse', mse.value);
    try {
      const advice = await get(`/api/runs/${run}/advice?${query}`);
      if (mine !== turn) return;
      replace(answer, h('p.quiet.note', {}, `${advice.within} of ${advice.measured} measured settings are within the budget.`),
        advice.closest && h('p', {}, 'Closest: ', h('strong', {}, label(advice.closest)), ` (${costsText(advice.closest)}).`),
        h('ul.advice', {}, advice.choices.map(({cost, best, runner_up: second, reason}) => h('li', {},
          h('h3', {}, titles[cost]), h('strong', {}, label(best)), h('p.quiet', {}, costsText(best)),
          h('p', {}, second ? ['Then ', h('span.label', {}, label(second)), ` ${costsText(second)}`] : 'Nothing else measured is within the budget.'),
          h('details', {}, h('summary', {}, 'Reason'), h('p', {}, reason))))));
    } catch (error) {
      if (mine === turn) replace(answer, h('p.problem', {role: 'alert'}, error.message));
    }
  }
  const form = h('form.budget', {onsubmit: ask, 'aria-label': 'Error budget'},
    field('FLIP, mean', flip, 'largest of any frame; empty: any'), field('MSE', mse, 'largest of any frame; empty: any'),
    h('button', {type: 'submit'}, 'Advise'));
  return {element: h('div', {}, form, answer), ask};
}
