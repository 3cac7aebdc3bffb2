// Chooses the page by the address's fragment and shows how the service is.
import {get, post} from './api.js';
import {capturePage} from './capture_page.js';
import {capturesPage} from './captures_page.js';
import {h, replace} from './dom.js';
import {nightPage} from './night_page.js';
import {nightsPage} from './nights_page.js';
import {runPage} from './run_page.js';
import {runsPage} from './runs_page.js';
import {signInPage} from './sign_in_page.js';

const routes = [
  [/^#?\/?$/, () => capturesPage(), 'captures'],
  [/^#\/captures\/([0-9a-f]{32})$/, (hash) => capturePage(hash), 'captures'],
  [/^#\/runs$/, () => runsPage(), 'runs'],
  [/^#\/runs\/(\d+)$/, (id) => runPage(Number(id)), 'runs'],
  [/^#\/nights$/, () => nightsPage(), 'nights'],
  [/^#\/nights\/(\d+)$/, (id) => nightPage(Number(id)), 'nights'],
];

// A page is {element, title, close}; `close` ends what the page has going on.
let current = null;
let turn = 0;

async function show() {
  const hash = location.hash;
  if (hash === '#main') return;  // the skip link
  const mine = ++turn;
  const main = document.getElementById('main');
  current?.close?.();
  current = null;
  const route = routes.find(([pattern]) => pattern.test(hash));
  for (const link of document.querySelectorAll('nav a')) {
    if (link.dataset.page === route?.[2]) link.setAttribute('aria-current', 'page');
    else link.removeAttribute('aria-current');
  }
  let page;
  try {
    page = route ? await route[1](...hash.match(route[0]).slice(1)) : notFound();
  } catch (error) {
    page = error.status === 401 ? signInPage(() => { show(); showState(); showCaller(); }) : {element: problem(error), title: 'Problem'};
  }
  if (mine !== turn) return page.close?.();  // the user is elsewhere already
  current = page;
  document.title = `${page.title} · Subpixel`;
  replace(main, page.element);
  window.scrollTo(0, 0);
}

function notFound() {
  return {element: h('section', {}, h('h1', {}, 'There is no such page'), h('p', {}, h('a', {href: '#/'}, 'To the captures'))), title: 'Not found'};
}

function problem(error) {
  return h('section', {}, h('h1', {}, error.what ?? 'This did not work'),
    h('p.problem', {role: 'alert'}, error.why || error.message), h('p', {}, h('a', {href: '#/'}, 'To the captures')));
}

async function showState() {
  const state = document.getElementById('service-state');
  try {
    const health = await get('/api/health');
    const busy = health.running + health.queued;
    state.textContent = busy === 0 ? 'idle' : `${health.running} running, ${health.queued} queued`;
  } catch {
    state.textContent = 'service not reachable';
  }
}

/** Who is signed in, where the service wants that, with the way out. */
async function showCaller() {
  const button = document.getElementById('sign-out');
  const caller = await get('/api/caller').catch(() => ({}));
  button.hidden = !caller.token_required;
  button.textContent = `Sign out ${caller.name ?? ''}`;
}

function setUpSignOut() {
  document.getElementById('sign-out').addEventListener('click', async () => {
    await post('/api/sign-out').catch(() => {});
    await showCaller();
    show();
  });
}

function setUpTheme() {
  const stored = localStorage.getItem('theme');
  if (stored) document.documentElement.dataset.theme = stored;
  document.getElementById('theme').addEventListener('click', () => {
    const dark = document.documentElement.dataset.theme
      ? document.documentElement.dataset.theme === 'dark'
      : matchMedia('(prefers-color-scheme: dark)').matches;
    document.documentElement.dataset.theme = dark ? 'light' : 'dark';
    localStorage.setItem('theme', document.documentElement.dataset.theme);
  });
}

setUpTheme();
setUpSignOut();
showCaller();
addEventListener('hashchange', show);
show();
showState();
setInterval(showState, 5000);
