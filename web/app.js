// Chooses the page by the address's fragment and shows how the service is. Pages are fetched when they are opened.
import {get, post} from './api.js';
import {announce, h, replace} from './dom.js';
import {listenToKeys, setKeys, showKeys} from './keys.js';
import {signInPage} from './sign_in_page.js';

const routes = [
  [/^#?\/?$/, async () => (await import('./captures_page.js')).capturesPage(), 'captures'],
  [/^#\/captures\/([0-9a-f]{32})$/, async (hash) => (await import('./capture_page.js')).capturePage(hash), 'captures'],
  [/^#\/runs$/, async () => (await import('./runs_page.js')).runsPage(), 'runs'],
  [/^#\/runs\/(\d+)$/, async (id) => (await import('./run_page.js')).runPage(Number(id)), 'runs'],
  [/^#\/nights$/, async () => (await import('./nights_page.js')).nightsPage(), 'nights'],
  [/^#\/trends$/, async () => (await import('./trends_page.js')).trendsPage(), 'nights'],
  [/^#\/nights\/(\d+)$/, async (id) => (await import('./night_page.js')).nightPage(Number(id)), 'nights'],
];

// A page is {element, title, close}; `close` ends what the page has going on.
let current = null;
let turn = 0;

async function show() {
  const [hash] = location.hash.split('?');  // what follows is the page's own (view_address.js)
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
  const slow = setTimeout(() => replace(main, h('section.loading', {role: 'status'}, h('h1', {}, 'Loading …'), h('div.skeleton', {}), h('div.skeleton', {}))), 150);
  let page;
  try {
    page = route ? await route[1](...hash.match(route[0]).slice(1)) : notFound();
  } catch (error) {
    page = error.status === 401 ? signInPage(() => { show(); showState(); showCaller(); }) : {element: problem(error), title: 'Problem'};
  }
  clearTimeout(slow);
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

const lost = h('p.lost-banner', {role: 'alert', hidden: true}, 'The service does not answer. What is shown stays; it is asked again every few seconds.');

async function showState() {
  const state = document.getElementById('service-state');
  try {
    const health = await get('/api/health');
    const busy = health.running + health.queued;
    state.textContent = busy === 0 ? 'idle' : `${health.running} running, ${health.queued} queued`;
    lost.hidden = true;
  } catch {
    state.textContent = 'not reachable';
    if (lost.hidden) announce(lost.textContent);
    lost.hidden = false;
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

function switchTheme() {
  const dark = document.documentElement.dataset.theme
    ? document.documentElement.dataset.theme === 'dark'
    : matchMedia('(prefers-color-scheme: dark)').matches;
  document.documentElement.dataset.theme = dark ? 'light' : 'dark';
  localStorage.setItem('theme', document.documentElement.dataset.theme);
}

function setUpTheme() {
  const stored = localStorage.getItem('theme');
  if (stored) document.documentElement.dataset.theme = stored;
  document.getElementById('theme').addEventListener('click', switchTheme);
}

setUpTheme();
setUpSignOut();
showCaller();
document.getElementById('main').before(lost);
document.getElementById('keys').addEventListener('click', showKeys);
setKeys('Everywhere', [
  {keys: ['?'], text: 'this list', act: showKeys},
  {keys: ['h'], text: 'captures', act: () => (location.hash = '#/')},
  {keys: ['u'], text: 'runs', act: () => (location.hash = '#/runs')},
  {keys: ['i'], text: 'nights', act: () => (location.hash = '#/nights')},
  {keys: ['D'], text: 'light or dark', act: switchTheme},
]);
listenToKeys();
addEventListener('hashchange', show);
show();
showState();
setInterval(showState, 5000);
