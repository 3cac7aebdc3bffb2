// The form that starts a run, made from the registry: each parameter by its kind, with its range, default, unit and doc.
import {post} from './api.js';
import {field, h} from './dom.js';

const baselines = ['noaa', 'msaa'];

// Returns {element, read}; read() gives the value, or undefined for "leave it to the run or the default".
function parameterControl(parameter, runSamples) {
  if (parameter.kind === 'boolean') {
    const box = h('input', {type: 'checkbox', checked: parameter.default === true});
    return {element: box, read: () => box.checked};
  }
  const choices = parameter.kind === 'choice' ? parameter.choices : parameter.allowed;
  if (choices?.length > 0) {
    const inherits = parameter.name === 'samples';
    const select = h('select', {},
      inherits && h('option', {value: ''}, `as the run (${runSamples()})`),
      choices.map((choice) => h('option', {value: choice, selected: !inherits && choice === parameter.default}, choice)));
    return {
      element: select,
      read: () => (select.value === '' ? undefined : parameter.kind === 'choice' ? select.value : Number(select.value)),
      runSamplesChanged: () => {
        if (inherits) select.options[0].textContent = `as the run (${runSamples()})`;
      },
    };
  }
  const input = h('input', {
    type: 'number', min: parameter.minimum, max: parameter.maximum, required: true,
    step: parameter.kind === 'integer' ? 1 : 'any', value: parameter.default,
  });
  return {element: input, read: () => input.valueAsNumber};
}

function parameterHint(parameter) {
  const parts = [parameter.doc];
  if (parameter.kind === 'integer' || parameter.kind === 'number') {
    const range = parameter.allowed?.length > 0 ? parameter.allowed.join(', ') : `${parameter.minimum} to ${parameter.maximum}`;
    parts.push(`${range}${parameter.unit ? ` ${parameter.unit}` : ''}, default ${parameter.default}`);
  } else {
    parts.push(`default ${parameter.default}`);
  }
  return parts.filter(Boolean).join(' · ');
}

// One technique with its parameters. A technique can be there several times with different parameters.
function variant(technique, runSamples, onRemove) {
  // A parameter with one value is no choice.
  const chosen = technique.parameters.filter((parameter) => parameter.allowed?.length !== 1);
  const controls = chosen.map((parameter) => ({parameter, ...parameterControl(parameter, runSamples)}));
  const element = h('div', {class: controls.length > 0 ? 'variant' : 'quiet'},
    controls.map(({parameter, element: control}) => field(parameter.name, control, parameterHint(parameter))),
    controls.length === 0 && 'no parameters',
    onRemove && h('button.plain.remove', {type: 'button', onclick: () => onRemove()}, 'Remove this variant'));
  return {
    element,
    runSamplesChanged: () => controls.forEach((control) => control.runSamplesChanged?.()),
    read: () => {
      const parameters = {};
      for (const {parameter, read} of controls) {
        const value = read();
        if (value !== undefined) parameters[parameter.name] = value;
      }
      return {technique: technique.name, parameters};
    },
  };
}

function techniqueEntry(technique, runSamples) {
  const variants = [];
  const list = h('div.variants', {});
  const more = h('button.plain', {type: 'button', onclick: () => add(true)}, '+ another variant');
  const box = h('input', {type: 'checkbox', checked: baselines.includes(technique.name), onchange: () => update()});
  const details = h('div.technique-details', {}, list, technique.parameters.length > 0 && more);
  function add(removable) {
    const entry = variant(technique, runSamples, removable && (() => {
      variants.splice(variants.indexOf(entry), 1);
      entry.element.remove();
    }));
    variants.push(entry);
    list.append(entry.element);
  }
  function update() {
    details.hidden = !box.checked;
    // Hidden fields must not hold the form back.
    for (const control of details.querySelectorAll('input, select')) control.disabled = !box.checked;
  }
  add(false);
  update();
  return {
    element: h('li.technique', {},
      h('label.technique-name', {}, box, h('strong', {}, technique.name), h('span', {}, technique.title)),
      technique.paper && h('div.quiet.paper', {}, technique.paper), details),
    read: () => (box.checked ? variants.map((entry) => entry.read()) : []),
    runSamplesChanged: () => variants.forEach((entry) => entry.runSamplesChanged()),
  };
}

/** A field for a whole number that the limit holds. */
function numberInput(limit, properties) {
  return h('input', {type: 'number', min: limit.low, max: limit.high, step: limit.multiple_of, ...properties});
}

function sampleCounts(registry, limit) {
  const allowed = registry.flatMap((technique) => technique.parameters)
    .filter((parameter) => parameter.name === 'samples' && parameter.allowed?.length !== 1)
    .flatMap((parameter) => parameter.allowed ?? []).filter((count) => limit.values.includes(count));
  return allowed.length > 0 ? [...new Set(allowed)].sort((a, b) => a - b) : [4, 8, 16];
}

function sizeControl(capture, limits) {
  const half = [Math.max(1, capture.width >> 1), Math.max(1, capture.height >> 1)];
  const select = h('select', {onchange: () => update()},
    h('option', {value: 'recorded'}, `as recorded (${capture.width}×${capture.height})`),
    h('option', {value: half.join('x')}, `half (${half.join('×')})`),
    ['640x360', '1280x720', '1920x1080'].map((size) => h('option', {value: size}, size.replace('x', '×'))),
    h('option', {value: 'own'}, 'other'));
  const width = numberInput(limits.width, {value: capture.width, required: true, 'aria-label': 'Width in pixels'});
  const height = numberInput(limits.height, {value: capture.height, required: true, 'aria-label': 'Height in pixels'});
  const own = h('span.own-size', {}, width, '×', height);
  function update() {
    own.hidden = select.value !== 'own';
    width.disabled = height.disabled = own.hidden;
  }
  update();
  return {
    element: h('div', {}, field('Size', select, 'pixels'), own),
    read: () => {
      if (select.value === 'recorded') return {};
      const [w, hh] = select.value === 'own' ? [width.valueAsNumber, height.valueAsNumber] : select.value.split('x').map(Number);
      return {width: w, height: hh};
    },
  };
}

export function runForm(capture, registry, limits) {
  const last = capture.frame_count - 1;
  const samples = h('select', {onchange: () => entries.forEach((entry) => entry.runSamplesChanged())},
    sampleCounts(registry, limits.samples).map((value) => h('option', {value, selected: value === 8}, value)));
  const entries = registry.map((technique) => techniqueEntry(technique, () => samples.value));
  const from = h('input', {type: 'number', min: 0, max: last, value: 0, required: true});
  const to = h('input', {type: 'number', min: 0, max: last, value: last, required: true});
  const size = sizeControl(capture, limits);
  const repeat = numberInput(limits.repeat, {value: 3, required: true});
  const reference = h('select', {}, [[512, '512'], [limits.reference_samples.high, `${limits.reference_samples.high} (slow)`], [256, '256'],
    [64, '64 (quick look)'], [0, 'none: no error']]
    .map(([value, label]) => h('option', {value}, label)));
  const lights = numberInput(limits.point_lights, {placeholder: 'as recorded'});
  const everyLight = h('input', {type: 'checkbox'});
  const memory = numberInput(limits.memory_mib, {placeholder: 'no limit'});
  const text = h('input', {type: 'text', placeholder: 'streaming:surfaces=1..4,msaa:samples=4|16', spellcheck: 'false'});
  const problem = h('p.problem', {role: 'alert'});
  const start = h('button.primary', {type: 'submit'}, 'Start run');

  async function submit(event) {
    event.preventDefault();
    problem.textContent = '';
    const chosen = entries.flatMap((entry) => entry.read());
    if (text.value.trim() !== '') chosen.push(text.value.trim());
    if (chosen.length === 0) {
      problem.textContent = 'Choose at least one technique.';
      return;
    }
    const body = {
      capture: capture.hash, techniques: chosen, samples: Number(samples.value),
      frames: [from.valueAsNumber, to.valueAsNumber], ...size.read(),
      repeat: repeat.valueAsNumber, reference_samples: Number(reference.value),
    };
    if (lights.value !== '') body.point_lights = lights.valueAsNumber;
    if (everyLight.checked) body.every_light = true;
    if (memory.value !== '') body.memory_mib = memory.valueAsNumber;
    start.disabled = true;
    try {
      const run = await post('/api/runs', body);
      location.hash = `#/runs/${run.id}`;
    } catch (error) {
      problem.textContent = error.message;
    } finally {
      start.disabled = false;
    }
  }

  return h('form.run-form', {onsubmit: submit, 'aria-label': 'New run'},
    h('fieldset', {}, h('legend', {}, 'Frames and measuring'),
      h('div.fields', {},
        field('Samples per pixel', samples, 'of techniques that are not given their own'),
        field('First frame', from, `0 to ${last}`), field('Last frame', to, `0 to ${last}`),
        size.element,
        field('Repeats', repeat, 'timed runs of each frame; the median counts'),
        field('Reference samples', reference, 'per pixel, for the error'),
        field('Point lights', lights, 'extra ones are placed in the scene'),
        field('Every light at every point', everyLight, 'not only those in reach: the same image, later'),
        field('Memory in MiB', memory, 'of what a frame holds; beyond it the frame is drawn in bands'))),
    h('fieldset', {}, h('legend', {}, 'Techniques'), h('ul.techniques', {}, entries.map((entry) => entry.element)),
      field('Further ones, as on the command line', text, 'name:parameter=value, several with commas; first..last and a|b sweep a parameter')),
    problem, h('p.actions', {}, start));
}
