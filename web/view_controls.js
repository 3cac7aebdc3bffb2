// The controls of a comparison: how layers are compared, which, how numbers are coloured, and the legends.
import {legend} from './colour_scales.js';
import {field, h, replace} from './dom.js';
import {fixed} from './format.js';
import {toneNames} from './pixel_math.js';
import {channels, isMap, measures, modes, plainLook, scaleIn, signless} from './view_state.js';

const options = (list, chosen) => list.map(([value, text]) => h('option', {value, selected: String(value) === String(chosen)}, text));

export class ViewControls {
  modes = h('div.chips', {role: 'group', 'aria-label': 'How layers are compared'});
  sides = h('div.view-sides', {});
  legends = h('div.legends', {});
  look = h('div.look', {});
  #change;
  #drawnFor = '';

  /** `change(state)` is called with what the user chose. */
  constructor(change) {
    this.#change = change;
  }

  draw(state, layers) {
    const {share: _share, scale: _scale, cx: _cx, cy: _cy, box: _box, ...chosen} = state;
    const key = JSON.stringify([chosen, layers.map(({label, kind, scale}) => [label, kind, scale])]);
    if (key === this.#drawnFor) return;  // frames follow each other with the same ones
    this.#drawnFor = key;
    const parts = [this.modes, this.sides, this.look];
    const focus = parts.some((part) => part.contains(document.activeElement)) ? document.activeElement.dataset.control : null;
    replace(this.modes, Object.entries(modes).map(([name, [title, shortcut]]) => h('button.chip', {
      type: 'button', 'aria-pressed': String(state.mode === name), 'aria-keyshortcuts': shortcut, 'data-control': name, disabled: layers.length < 2,
      onclick: () => this.#change({mode: name})}, title)));
    this.#drawSides(state, layers);
    this.#drawLook(state);
    this.#drawLegends(state, layers);
    if (focus) parts.map((part) => part.querySelector(`[data-control="${focus}"]`)).find(Boolean)?.focus();
  }

  #drawSides({mode, a, b, measure, signed, gain}, layers) {
    const select = (label, value, list, set, name) => field(label, h('select', {value, 'data-control': name, onchange: (event) => set(event.target.value)}, options(list, value)));
    const layerOptions = layers.map((layer, i) => [i, `${i + 1}: ${layer.label}`]);
    replace(this.sides, layers.length > 1 && mode !== 'side' && [
      select(mode === 'flip' ? 'Shown' : mode === 'wipe' ? 'Left' : 'Of', a, layerOptions, (value) => this.#change({a: Number(value)}), 'a'),
      mode !== 'flip' && select(mode === 'wipe' ? 'Right' : 'minus', b, layerOptions, (value) => this.#change({b: Number(value)}), 'b'),
      mode === 'difference' && [
        select('Measure', measure, Object.entries(measures), (value) => this.#change({measure: value}), 'measure'),
        select('Gain', gain, [1, 2, 4, 8, 16, 32, 64].map((v) => [v, `×${v}`]), (value) => this.#change({gain: Number(value)}), 'gain'),
        h('label.check', {}, h('input', {type: 'checkbox', checked: signed, disabled: signless.includes(measure), 'data-control': 'signed', onchange: () => this.#change({signed: !signed})}), 'signed'),
      ]]);
  }

  #drawLook({exposure, tone, channel, falseColour, log, palette: named, low, high}) {
    const stops = `${exposure > 0 ? '+' : ''}${fixed(exposure, 2)} EV`;
    // A slider that is being drawn along stays the same one.
    const slider = this.look.querySelector('[data-control="exposure"]');
    if (slider && slider === document.activeElement) {
      slider.value = exposure;
      this.look.querySelector('output').textContent = stops;
      return;
    }
    const open = this.look.querySelector('details')?.open ?? false;
    const number = (value, name) => h('input', {type: 'number', step: 'any', value: value ?? '', 'data-control': name, onchange: (event) =>
      this.#change({[name]: event.target.value === '' ? null : event.target.valueAsNumber})});
    const choice = (value, list, name) => h('select', {'data-control': name, onchange: (event) => this.#change({[name]: event.target.value})}, options(list, value));
    const check = (label, value, name) => h('label.check', {}, h('input', {type: 'checkbox', checked: value, 'data-control': name, onchange: (event) => this.#change({[name]: event.target.checked})}), label);
    replace(this.look, h('details', {open}, h('summary', {}, 'Exposure, tone and false colour'),
      h('div.look-fields', {},
        h('label.exposure', {}, h('span', {}, 'Exposure'), h('input', {type: 'range', min: -8, max: 8, step: 0.25, value: exposure, 'aria-label': 'Exposure in stops', 'data-control': 'exposure',
          oninput: (event) => this.#change({exposure: event.target.valueAsNumber})}), h('output', {}, stops)),
        field('Tone', choice(tone, toneNames.map((name) => [name, {none: 'none (clamped)', reinhard: 'Reinhard', aces: 'ACES'}[name]]), 'tone')),
        field('Channel', choice(channel, Object.entries(channels), 'channel')),
        check('false colour', falseColour, 'falseColour'), check('logarithmic', log, 'log'),
        field('Colours', choice(named, [['', "each map's own"], ['viridis', 'viridis'], ['magma', 'magma'], ['grey', 'grey']], 'palette')),
        field('From', number(low, 'low')), field('To', number(high, 'high')),
        h('button', {type: 'button', onclick: () => this.#change(plainLook)}, 'Reset'))));
  }

  #drawLegends(state, layers) {
    const {mode, a, b, falseColour} = state;
    const visible = mode === 'side' ? layers : mode === 'wipe' ? [layers[a], layers[b]] : mode === 'flip' ? [layers[a]] : [];
    const scales = visible.filter((layer) => layer && (isMap(layer) || falseColour)).map((layer) => scaleIn(state, layer));
    const unique = [...new Map(scales.map((scale) => [JSON.stringify([scale.map, scale.low, scale.maximum, scale.log, scale.description]), scale])).values()];
    replace(this.legends, unique.map(legend));
  }
}
