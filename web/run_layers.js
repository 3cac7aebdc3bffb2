// The layers that a run's results have: "*:image" is the image of the selected technique, "2:error" the error map of the third
// row. Such keys stay when frames and techniques change.
import {blobUrl} from './api.js';
import {scaleOf} from './colour_scales.js';

const titles = {image: 'image', hdr: 'linear image', reference: 'reference', reference_hdr: 'linear reference'};
const order = ['image', 'reference', 'error', 'flip', 'shading'];
export const rank = (role) => (order.includes(role) ? order.indexOf(role) : role.endsWith('hdr') ? 99 : 10);

/** What a result can show, by role: maps by the name of the map, whose numbers are "NAME_values". */
export function rolesOf(result) {
  const roles = new Set(Object.keys(result.images).map((role) => role.replace(/_values$/, '')));
  return [...roles].sort((a, b) => rank(a) - rank(b));
}

export function roleTitle(role, row, result) {
  return titles[role] ?? `${scaleOf(role, row.entry, result)?.title ?? role} map`;
}

/** The layer of a role, or null where the result does not have it. */
export function layerOf(key, row, result, role) {
  const {images} = result;
  const reference = images.reference && {url: blobUrl(images.reference), kind: 'display'};
  if (role === 'image') return images.image ? {key, kind: 'display', url: blobUrl(images.image), label: row.label, reference} : null;
  if (role === 'reference') return reference ? {key, ...reference, label: 'reference'} : null;
  if (role.endsWith('hdr')) {
    const label = role === 'hdr' ? `${row.label}: linear` : 'reference: linear';
    return images[role] ? {key, kind: 'linear', url: blobUrl(images[role]), label, reference: role === 'hdr' ? reference : null} : null;
  }
  const scale = scaleOf(role, row.entry, result);
  const label = `${row.label}: ${(scale?.title ?? role).toLowerCase()}`;
  const values = images[`${role}_values`];
  if (values && scale) return {key, kind: 'map', url: blobUrl(values), label, scale};
  // Of runs before maps had numbers: the colours are all there is.
  return images[role] ? {key, kind: 'display', url: blobUrl(images[role]), label: `${label} (colours)`} : null;
}
