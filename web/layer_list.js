// The layers of a view in their order, with a control that adds one and buttons that take them away.
import {field, h, replace} from './dom.js';
import {rolesOf, roleTitle} from './run_layers.js';
import {maxLayers} from './view_state.js';

export class LayerList {
  element = h('div.layer-list', {});
  #shown;
  #set;
  #drawnFor = '';

  /** `shown` {rows, row, frame}; `set(keys)` is called with the layers that shall be there. */
  constructor(shown, set) {
    this.#shown = shown;
    this.#set = set;
  }

  #row(place) {
    const {rows, row} = this.#shown;
    return rows[place === '*' ? row : Number(place)];
  }

  // What a row's result has: [role, title].
  #roles(place) {
    const row = this.#row(place);
    const result = row?.results.get(this.#shown.frame);
    return result ? rolesOf(result).map((role) => [role, roleTitle(role, row, result)]) : [];
  }

  #title(key) {
    const [place, role] = key.split(':');
    const title = this.#roles(place).find(([name]) => name === role)?.[1] ?? role;
    return `${place === '*' ? 'selected technique' : this.#row(place)?.label ?? 'no such technique'}: ${title}`;
  }

  draw(keys) {
    const places = ['*', ...this.#shown.rows.keys()].map(String);
    const entries = places.map((place) => ({place, label: place === '*' ? 'selected technique' : this.#row(place).label, roles: this.#roles(place)}));
    const titles = keys.map((key) => this.#title(key));
    const drawnFor = JSON.stringify([entries, titles]);
    if (drawnFor === this.#drawnFor) return;  // frames follow each other with the same ones
    this.#drawnFor = drawnFor;
    const open = this.element.querySelector('details')?.open ?? false;
    const chosen = this.element.querySelector('select')?.value ?? '*';
    const what = h('select', {});
    const fill = (place) => replace(what, entries.find((entry) => entry.place === place)?.roles.map(([role, title]) => h('option', {value: role}, title)) ?? []);
    const who = h('select', {onchange: () => fill(who.value)}, entries.map(({place, label}) => h('option', {value: place, selected: place === chosen}, label)));
    fill(who.value);
    replace(this.element, h('details', {open}, h('summary', {}, `Layers (${keys.length} of at most ${maxLayers})`),
      h('ol', {}, keys.map((key, i) => h('li', {}, titles[i], keys.length > 1 && h('button.plain', {type: 'button', 'aria-label': `Take away layer ${i + 1}`,
        onclick: () => this.#set(keys.filter((_, other) => other !== i))}, '✕')))),
      h('div.layer-add', {}, field('of', who), field('layer', what), h('button', {type: 'button', disabled: keys.length >= maxLayers, onclick: () => {
        const key = `${who.value}:${what.value}`;
        if (what.value && !keys.includes(key)) this.#set([...keys, key]);
      }}, 'Add layer'))));
  }
}
