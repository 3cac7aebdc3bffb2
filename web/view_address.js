// What is on the screen, in the address: "#/runs/7?frame=3&mode=side". Such an address restores it whole.

import {announce} from './dom.js';

const [path, query] = [() => location.hash.split('?')[0], () => location.hash.split('?')[1] ?? ''];

export class ViewAddress {
  #values = new URLSearchParams(query());
  #path = path();
  #timer = 0;

  text(name, absent = '') {
    return this.#values.get(name) ?? absent;
  }

  number(name, absent) {
    const value = Number.parseFloat(this.#values.get(name) ?? '');
    return Number.isFinite(value) ? value : absent;
  }

  flag(name) {
    return this.#values.get(name) === '1';
  }

  /** Sets what is given; null, "", false and what equals `absent` go out of the address. */
  set(entries) {
    for (const [name, value] of Object.entries(entries)) {
      if (value === null || value === undefined || value === '' || value === false) this.#values.delete(name);
      else this.#values.set(name, value === true ? '1' : String(value));
    }
    // Browsers take few changes of the address a second.
    this.#timer ||= setTimeout(() => this.write(), 150);
    document.body.dataset.address = 'due';  // for tests
  }

  /** Puts it on the clipboard. */
  async copy() {
    this.write();
    try {
      await navigator.clipboard.writeText(location.href);
      announce('The address of this view is copied');
    } catch {
      announce('The address bar has the address of this view');
    }
  }

  write() {
    clearTimeout(this.#timer);
    this.#timer = 0;
    delete document.body.dataset.address;
    if (path() !== this.#path) return;  // the user is elsewhere
    const text = String(this.#values);
    history.replaceState(null, '', text ? `${this.#path}?${text}` : this.#path);
  }
}

// The comparison's state by the names it has in the address.
const numbers = {a: 'a', b: 'b', share: 'line', scale: 'zoom', cx: 'x', cy: 'y', gain: 'gain', exposure: 'ev', low: 'low', high: 'high'};
const texts = {mode: 'mode', measure: 'measure', tone: 'tone', channel: 'channel', palette: 'colours'};
const flags = {signed: 'signed', falseColour: 'false', log: 'log', magnify: 'magnifier', worst: 'worst'};
const usual = {a: 0, b: 1, share: 0.5, scale: 0, gain: 4, exposure: 0, mode: 'wipe', measure: 'largest', tone: 'none', channel: 'all'};
const boxParts = ['x', 'y', 'width', 'height'];

export function saveView(address, state) {
  const entries = {box: state.box && boxParts.map((part) => state.box[part]).join(',')};
  for (const [key, name] of Object.entries({...numbers, ...texts, ...flags})) {
    const value = typeof state[key] === 'number' ? Number(state[key].toFixed(4)) : state[key];
    entries[name] = value === usual[key] ? null : value;
  }
  address.set(entries);
}

export function loadView(address) {
  const state = {};
  for (const [key, name] of Object.entries(numbers)) state[key] = address.number(name, usual[key] ?? null);
  for (const [key, name] of Object.entries(texts)) state[key] = address.text(name, usual[key] ?? '');
  for (const [key, name] of Object.entries(flags)) state[key] = address.flag(name);
  const box = address.text('box').split(',').map(Number);
  state.box = box.length === 4 && box.every((value) => Number.isInteger(value) && value >= 0) ? Object.fromEntries(boxParts.map((part, i) => [part, box[i]])) : null;
  if (state.cx === null || state.cy === null) state.scale = 0;
  return state;
}
