// The images of a run's frame: what is shown of them, chosen by chips and by a list of layers, with a pixel's story and the files.
import {blobUrl} from './api.js';
import {CompareView} from './compare_view.js';
import {h, replace} from './dom.js';
import {Later} from './later.js';
import {LayerList} from './layer_list.js';
import {PixelStory} from './pixel_story.js';
import {counters, executionHistogram} from './result_details.js';
import {layerOf, rank, rolesOf, roleTitle} from './run_layers.js';
import {baselineOf} from './run_rows.js';
import {loadView, saveView} from './view_address.js';
import {maxLayers} from './view_state.js';

const framesAhead = {playing: 3, still: 1};

export class RunImages {
  view;
  story = new PixelStory((pixel) => this.#chooseBeside(pixel));
  chips = h('div.chips', {role: 'group', 'aria-label': 'What is shown'});
  state = h('p.quiet', {role: 'status'});
  files = h('p.files', {});
  details = h('div.result-details', {});
  #shown;        // {run, rows, row, frame}, the page's
  #address;
  #layerKeys;
  #compared;              // keys of the two layers that are compared: results that are not there yet may have them
  #placed = {a: 0, b: 1}; // where they are, or what is shown in their place
  #list;
  #chipsFor = '';
  #filesFor = '';
  #playing = false;
  #told = null;  // {x, y, row, frame}: whose story is told
  #later = [new Later(this.files, () => this.#drawFiles()), new Later(this.details, () => this.#drawDetails())];

  /** `shown` {run, rows, row, frame} is followed: draw() shows what it says then. */
  constructor(shown, address) {
    this.#shown = shown;
    this.#address = address;
    this.#layerKeys = address.text('layers') ? address.text('layers').split(',').slice(0, maxLayers) : this.#usualKeys();
    this.view = new CompareView((state) => {
      saveView(address, state);
      if (state.a !== this.#placed.a || state.b !== this.#placed.b) this.#compare(state);
      this.#drawChips();
    });
    const state = loadView(address);
    this.view.restore(state);
    this.#compared = [this.#layerKeys[state.a], this.#layerKeys[state.b]];
    this.#list = new LayerList(shown, (keys) => this.#setLayerKeys(keys));
    this.view.element.addEventListener('pixelchosen', ({detail}) => this.#choose(detail));
    const [x, y, row, frame] = address.text('pixel').split(',').map(Number);
    if ([x, y, frame].every((number) => Number.isInteger(number) && number >= 0) && shown.rows[row]) this.#tell({x, y, row, frame});
  }

  get layerList() {
    return this.#list.element;
  }

  #usualKeys() {
    const {run, rows} = this.#shown;
    if (run.request.reference_samples > 0) return ['*:image', '*:reference', '*:error', '*:shading'];
    const baseline = baselineOf(run, rows);
    return ['*:image', ...(baseline ? [`${rows.indexOf(baseline)}:image`] : []), '*:shading'];
  }

  // A pixel of the layer that was clicked. Its story stays that of the frame and technique at hand now.
  #choose({x, y, layer}) {
    const {rows, row, frame} = this.#shown;
    const place = layer?.key.split(':')[0] ?? '*';  // a layer's key begins with its row, or "*" for the selected one
    this.#tell({x, y, row: place === '*' || !rows[place] ? row : Number(place), frame});
  }

  // From the story itself: another pixel of the same row and frame, or null when it was closed.
  #chooseBeside(pixel) {
    if (pixel) return this.#tell({...this.#told, ...pixel});
    this.#told = null;
    this.#address.set({pixel: null});
    this.view.mark(null);
  }

  #tell(told) {
    this.#told = told;
    const {x, y, row, frame} = told;
    const {run, rows} = this.#shown;
    const {technique, parameters} = rows[row];
    const {samples, reference_samples: reference, point_lights: lights} = run.request;
    const {width, height} = run.head ?? run.request;
    this.#address.set({pixel: [x, y, row, frame].join(',')});
    this.view.mark({x, y});
    this.story.show({hash: run.capture.hash, technique, parameters, samples, frame, width: width || undefined, height: height || undefined,
      reference_samples: reference === 0 ? 0 : undefined, point_lights: lights}, {x, y});
  }

  get #result() {
    const {rows, row, frame} = this.#shown;
    return rows[row].results.get(frame);
  }

  #layer(key, frame = this.#shown.frame) {
    const [place, role] = key.split(':');
    const row = this.#shown.rows[place === '*' ? this.#shown.row : Number(place)];
    const result = row?.results.get(frame);
    return result && role ? layerOf(key, row, result, role) : null;
  }

  /** Draws what `shown` says; `playing` reads further ahead. */
  draw(playing = false) {
    this.#playing = playing;
    const {run, rows, row, frame} = this.#shown;
    const layers = this.#layerKeys.map((key) => this.#layer(key)).filter(Boolean);
    this.view.element.hidden = layers.length === 0;
    const waits = ['queued', 'running'].includes(run.status) || run.stored_results > 0 && rows[row].results.size === 0;
    this.state.textContent = this.#result ? '' : `Frame ${frame} of ${rows[row].label} is not there${waits ? ' yet' : ''}.`;
    this.state.hidden = Boolean(this.#result);
    if (layers.length > 0) this.#showLayers(layers);
    this.#drawChips();
    this.#list.draw(this.#layerKeys);
    for (const part of this.#later) part.ask();
  }

  #compare(state) {
    this.#placed = {a: state.a, b: state.b};
    this.#compared = [this.view.layers[state.a]?.key, this.view.layers[state.b]?.key];
  }

  // The two that are compared stay the same by their keys.
  #showLayers(layers) {
    const {a, b} = this.view.state;
    const index = (key, i) => {
      const kept = layers.findIndex((layer) => layer.key === key);
      return kept >= 0 ? kept : Math.min(i, layers.length - 1);
    };
    this.#placed = {a: index(this.#compared[0], a), b: index(this.#compared[1], b)};
    this.view.setLayers(layers, this.#placed);
    // One that was taken away is no longer waited for.
    this.#compared = this.#compared.map((key, i) => (this.#layerKeys.includes(key) ? key : layers[i === 0 ? this.#placed.a : this.#placed.b].key));
    const {run, frame: now} = this.#shown;
    const ahead = this.#playing ? framesAhead.playing : framesAhead.still;
    this.view.settled.then(() => {
      for (let frame = now + 1; frame <= Math.min(run.request.frames[1], now + ahead); ++frame) {
        this.view.readAhead(this.#layerKeys.map((key) => this.#layer(key, frame)).filter(Boolean));
      }
    });
  }

  // What is looked at most, at one click.
  #presets() {
    const {run, rows, row: selected} = this.#shown;
    const [row, result] = [rows[selected], this.#result];
    if (!result) return [];
    const baseline = baselineOf(run, rows);
    const other = baseline && baseline !== row ? rows.indexOf(baseline) : -1;
    return [
      result.images.reference && {title: 'Image ⇔ reference', a: '*:image', b: '*:reference', share: 0.5},
      other >= 0 && {title: `Image ⇔ ${baseline.label}`, a: '*:image', b: `${other}:image`, share: 0.5},
      // The image lies behind the map: the line starts at the right edge and can be drawn over it.
      ...rolesOf(result).filter((role) => role !== 'image' && !role.startsWith('reference') && role !== 'hdr')
        .map((role) => ({title: roleTitle(role, row, result), a: `*:${role}`, b: '*:image', share: 1})),
      result.images.hdr && result.images.reference_hdr && {title: 'Linear images', a: '*:hdr', b: '*:reference_hdr', share: 0.5},
    ].filter(Boolean);
  }

  #drawChips() {
    const {mode, a, b} = this.view.state;
    const [left, right] = [this.view.layers[a]?.key, this.view.layers[b]?.key];
    const presets = this.#presets().map((preset) => ({...preset, pressed: mode === 'wipe' && preset.a === left && preset.b === right}));
    const chipsFor = JSON.stringify(presets);
    if (chipsFor === this.#chipsFor) return;
    this.#chipsFor = chipsFor;
    const focused = this.chips.contains(document.activeElement);
    replace(this.chips, presets.map((preset) => h('button.chip', {type: 'button', 'aria-pressed': String(preset.pressed), onclick: () => this.#showPreset(preset)}, preset.title)));
    if (focused) this.chips.querySelector('[aria-pressed="true"]')?.focus();
  }

  #showPreset({a, b, share}) {
    const keys = [...this.#layerKeys];
    for (const key of [a, b]) {
      if (keys.includes(key)) continue;
      if (keys.length === maxLayers) keys.splice(keys.findLastIndex((other) => other !== a && other !== b), 1);
      keys.push(key);
    }
    this.#setLayerKeys(keys);
    const at = (key) => Math.max(0, this.view.layers.findIndex((layer) => layer.key === key));
    this.view.change({mode: 'wipe', a: at(a), b: at(b), share});
  }

  #setLayerKeys(keys) {
    this.#layerKeys = keys;
    this.#address.set({layers: keys.join(',')});
    this.draw(this.#playing);
  }

  #drawFiles() {
    const {run, rows, row} = this.#shown;
    const result = this.#result;
    const roles = result ? Object.keys(result.images).sort((p, q) => rank(p) - rank(q)) : [];
    if (String(roles) !== this.#filesFor) {
      this.#filesFor = String(roles);
      replace(this.files, result && ['Files: ', roles.map((role) => h('a', {}, role.replaceAll('_', ' ')))]);
    }
    this.files.querySelectorAll('a').forEach((link, i) => {
      link.href = blobUrl(result.images[roles[i]]);
      link.download = fileName(run.id, rows[row].label, result, roles[i]);
    });
  }

  #drawDetails() {
    const result = this.#result;
    replace(this.details, result && [executionHistogram(result), counters(result)]);
  }

  close() {
    this.view.close();
    for (const part of this.#later) part.close();
  }
}

function fileName(run, label, result, role) {
  return `run${run}-${label.replace(/[^\w=.-]+/g, '_')}-frame${result.frame}-${role}.${/(hdr|_values)$/.test(role) ? 'exr' : 'png'}`;
}
