// Builds elements. Text only ever becomes text nodes, so names from captures can hold anything: nothing here parses HTML.

/**
 * @param {string} tag  "div", or "div.class.other"
 * @param {object} properties  attributes; `on…` functions listen; booleans set or leave out; `value`, `checked` are properties
 * @param {...(Node|string|number|null|undefined|false|Array)} children
 */
export function h(tag, properties = {}, ...children) {
  const [name, ...classes] = tag.split('.');
  const element = document.createElement(name);
  if (classes.length > 0) element.className = classes.join(' ');
  for (const [key, value] of Object.entries(properties ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (key === 'value' || key === 'checked' || key === 'indeterminate') element[key] = value;
    else if (key === 'class') element.classList.add(...value.split(' ').filter(Boolean));
    else element.setAttribute(key, value === true ? '' : String(value));
  }
  append(element, children);
  return element;
}

export function append(parent, children) {
  for (const child of children.flat(Infinity)) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child instanceof Node ? child : String(child));
  }
}

export function replace(parent, ...children) {
  parent.replaceChildren();
  append(parent, children);
}

// What is set as it is already makes the browser lay it out again, so it is asked first.
/** The text of an element without children. */
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** An attribute, which null takes away. */
export function setAttribute(element, name, value) {
  if (value === null) element.removeAttribute(name);
  else if (element.getAttribute(name) !== value) element.setAttribute(name, value);
}

/** Says something to screen readers. */
export function announce(text) {
  document.getElementById('announcer').textContent = text;
}

let ids = 0;
/** A label bound to its control, with a hint below that the control is described by. */
export function field(label, control, hint = '') {
  const id = `field-${++ids}`;
  control.id = id;
  if (hint) control.setAttribute('aria-describedby', `${id}-hint`);
  return h('div.field', {}, h('label', {for: id}, label), control,
    hint && h('small', {id: `${id}-hint`}, hint));
}
