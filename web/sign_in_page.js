// The form that takes a token where the service wants one.
import {post} from './api.js';
import {field, h} from './dom.js';

/** `onDone()` once the service has taken the token; the browser then has its cookie. */
export function signInPage(onDone) {
  const token = h('input', {type: 'password', name: 'token', autocomplete: 'current-password', required: true, spellcheck: 'false'});
  const problem = h('p.problem', {role: 'alert'});
  const form = h('form', {onsubmit: async (event) => {
    event.preventDefault();
    problem.textContent = '';
    try {
      await post('/api/sign-in', {token: token.value.trim()});
    } catch (error) {
      problem.textContent = error.why || error.message;
      return;
    }
    onDone();
  }}, field('Token', token, 'Whoever runs the service makes it with "subpixel token add".'), problem,
  h('button', {type: 'submit'}, 'Sign in'));
  return {element: h('section', {}, h('h1', {}, 'Sign in'), form), title: 'Sign in'};
}
