// Numbers as people read them.

const plain = new Intl.NumberFormat('en', {maximumFractionDigits: 0});

export const missing = '–';

export function count(value) {
  return Number.isFinite(value) ? plain.format(value) : missing;
}

/** 1234567 as "1.23 M". */
export function shortCount(value) {
  if (!Number.isFinite(value)) return missing;
  for (const [size, unit] of [[1e9, 'G'], [1e6, 'M'], [1e3, 'k']]) {
    if (value >= size) return `${significant(value / size, 3)} ${unit}`;
  }
  return plain.format(value);
}

export function bytes(value) {
  if (!Number.isFinite(value)) return missing;
  for (const [size, unit] of [[2 ** 30, 'GiB'], [2 ** 20, 'MiB'], [2 ** 10, 'KiB']]) {
    if (value >= size) return `${significant(value / size, 3)} ${unit}`;
  }
  return `${value} B`;
}

export function significant(value, digits) {
  if (!Number.isFinite(value)) return missing;
  if (value === 0) return '0';
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value))));
  return value.toFixed(Math.min(decimals, 8));
}

export function fixed(value, decimals) {
  return Number.isFinite(value) ? value.toFixed(decimals) : missing;
}

/** Small errors: "6.31e-4". */
export function scientific(value) {
  if (!Number.isFinite(value)) return missing;
  return value === 0 ? '0' : value.toExponential(2).replace('e+', 'e');
}

export function when(utc) {
  if (!utc) return missing;
  return new Date(utc).toLocaleString(undefined, {dateStyle: 'medium', timeStyle: 'short'});
}

export function duration(seconds) {
  if (!Number.isFinite(seconds)) return missing;
  if (seconds < 60) return `${Math.round(seconds)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min ${Math.round(seconds % 60)} s`;
  return `${Math.floor(seconds / 3600)} h ${Math.round((seconds % 3600) / 60)} min`;
}

/** "msaa samples=8": the parameters that differ from the registry's defaults, or all of them without a
 * registry entry; the samples always, unless there is no choice of them. */
export function techniqueLabel(technique, parameters, registryEntry) {
  const shown = Object.entries(parameters ?? {}).filter(([name, value]) => {
    const declared = registryEntry?.parameters.find((parameter) => parameter.name === name);
    if (name === 'samples') return declared?.allowed?.length !== 1;
    return !declared || declared.default !== value;
  });
  return [technique, ...shown.map(([name, value]) => `${name}=${shortValue(value)}`)].join(' ');
}

function shortValue(value) {
  return typeof value === 'number' && !Number.isInteger(value) ? significant(value, 4) : String(value);
}
