// Keys of the page on the screen, and the list of them that `?` opens. A page sets its own; those of the whole page stay.
import {h, replace} from './dom.js';

const groups = new Map();  // title -> [{keys, text, act}]

/** Sets the keys of a group: [{keys: ['f'], text: 'what it does', act}]; none takes them away. */
export function setKeys(title, bindings = []) {
  if (bindings.length > 0) groups.set(title, bindings);
  else groups.delete(title);
}

const typing = (target) => target instanceof HTMLElement && (target.isContentEditable || target.tagName === 'TEXTAREA' || target.tagName === 'SELECT' ||
  (target.tagName === 'INPUT' && !['range', 'checkbox', 'radio'].includes(target.type)));

const dialog = h('dialog.keys', {'aria-labelledby': 'keys-title'});

export function showKeys() {
  const names = {' ': 'Space', ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', Escape: 'Esc'};
  replace(dialog, h('form.keys-head', {method: 'dialog'}, h('h2', {id: 'keys-title'}, 'Keys'), h('button', {type: 'submit', autofocus: true}, 'Close')),
    [...groups].map(([title, bindings]) => h('section', {}, h('h3', {}, title), h('dl', {}, bindings.map(({keys, text}) =>
      h('div', {}, h('dt', {}, keys.map((key) => h('kbd', {}, names[key] ?? key))), h('dd', {}, text)))))));
  if (!dialog.isConnected) document.body.append(dialog);
  if (!dialog.open) dialog.showModal();
}

export function listenToKeys() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented || dialog.open || typing(event.target)) return;
    // A slider or a button has its own use for these.
    const own = ['INPUT', 'BUTTON', 'SUMMARY', 'A'].includes(event.target.tagName) && [' ', 'Enter'].includes(event.key);
    if (own || event.key.startsWith('Arrow')) return;
    for (const bindings of groups.values()) {
      const binding = bindings.find(({keys}) => keys.includes(event.key));
      if (!binding) continue;
      event.preventDefault();
      return binding.act(event.key);
    }
  });
}
