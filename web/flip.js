// FLIP of any two images on the screen, as replay/measure/flip.cpp has it: the difference a person sees when they alternate.
// Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating Images",
// Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Numbers below are of its section 4.

const pixelsPerDegree = 0.7 * (3840 / 0.7) * (Math.PI / 180);
const sensitivity = {achromatic: {a: 1, b: 0.0047}, redGreen: {a: 1, b: 0.0053}, blueWide: {a: 34.1, b: 0.04}, blueNarrow: {a: 13.5, b: 0.025}};
const featureWidth = 0.082;  // degrees
const colourExponent = 0.7;
const compressedShare = 0.4;
const compressedTo = 0.95;
const xyzFromRgb = [[10135552 / 23359437, 8788810 / 23359437, 4435075 / 23359437],
  [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897], [1425312 / 80288307, 8788810 / 80288307, 70074185 / 80288307]];
const rgbFromXyz = inverse(xyzFromRgb);

function inverse(m) {
  const minor = (i, j) => {
    const [a, b] = [(j + 1) % 3, (j + 2) % 3];
    const [c, d] = [(i + 1) % 3, (i + 2) % 3];
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(1, 0) + m[0][2] * minor(2, 0);
  return [0, 1, 2].map((i) => [0, 1, 2].map((j) => minor(i, j) / determinant));
}

const times = (m, [a, b, c]) => m.map((row) => row[0] * a + row[1] * b + row[2] * c);
const labCurve = (t) => (t > (6 / 29) ** 3 ? Math.cbrt(t) : t / (3 * (6 / 29) ** 2) + 4 / 29);

function huntLab([x, y, z]) {
  const [fx, fy, fz] = [labCurve(x), labCurve(y), labCurve(z)];
  const lightness = 116 * fy - 16;
  return [lightness, 0.01 * lightness * 500 * (fx - fy), 0.01 * lightness * 200 * (fy - fz)];
}

const bell = (scale, radius) => Array.from({length: 2 * radius + 1}, (_, i) => Math.exp(-scale * (i - radius) ** 2));
const sum = (values) => values.reduce((total, value) => total + value, 0);
const normalised = (values) => values.map((value) => value / sum(values));
const balanced = (values) => {
  const positive = sum(values.filter((value) => value > 0));
  const negative = -sum(values.filter((value) => value < 0));
  return values.map((value) => value / (value > 0 ? positive : negative || 1));
};

function convolve(plane, width, height, kernelX, kernelY) {
  const radiusX = (kernelX.length - 1) / 2;
  const radiusY = (kernelY.length - 1) / 2;
  const across = new Float32Array(plane.length);
  const padded = new Float32Array(width + 2 * radiusX);
  for (let y = 0; y < height; ++y) {
    const row = y * width;
    for (let i = 0; i < padded.length; ++i) padded[i] = plane[row + Math.min(Math.max(i - radiusX, 0), width - 1)];
    for (let x = 0; x < width; ++x) {
      let total = 0;
      for (let k = 0; k < kernelX.length; ++k) total += kernelX[k] * padded[x + k];
      across[row + x] = total;
    }
  }
  const out = new Float32Array(plane.length);
  for (let y = 0; y < height; ++y) {
    const row = y * width;
    for (let k = 0; k < kernelY.length; ++k) {
      const from = Math.min(Math.max(y + k - radiusY, 0), height - 1) * width;
      const weight = kernelY[k];
      for (let x = 0; x < width; ++x) out[row + x] += weight * across[from + x];
    }
  }
  return out;
}

// {lab: three planes, edge, point} of an image given by three planes of linear sRGB.
function features([red, green, blue], width, height) {
  const count = width * height;
  const opponent = [0, 1, 2].map(() => new Float32Array(count));
  for (let i = 0; i < count; ++i) {
    const [x, y, z] = times(xyzFromRgb, [red[i], green[i], blue[i]]);
    opponent[0][i] = y;
    opponent[1][i] = x - y;
    opponent[2][i] = y - z;
  }
  const radius = Math.ceil(3 * Math.sqrt(sensitivity.blueWide.b / (2 * Math.PI ** 2)) * pixelsPerDegree);
  const kernel = ({b}) => bell(Math.PI ** 2 / (b * pixelsPerDegree ** 2), radius);
  const smooth = (plane, gaussian) => convolve(plane, width, height, normalised(kernel(gaussian)), normalised(kernel(gaussian)));
  const weight = (gaussian) => gaussian.a * Math.sqrt(Math.PI / gaussian.b) * sum(kernel(gaussian)) ** 2;
  const wideShare = weight(sensitivity.blueWide) / (weight(sensitivity.blueWide) + weight(sensitivity.blueNarrow));
  const luminance = smooth(opponent[0], sensitivity.achromatic);
  const redGreen = smooth(opponent[1], sensitivity.redGreen);
  const wide = smooth(opponent[2], sensitivity.blueWide);
  const narrow = smooth(opponent[2], sensitivity.blueNarrow);
  const lab = [0, 1, 2].map(() => new Float32Array(count));
  const inside = (value) => Math.min(Math.max(value, 0), 1);
  for (let i = 0; i < count; ++i) {
    const y = luminance[i];
    const rgb = times(rgbFromXyz, [redGreen[i] + y, y, y - (wideShare * wide[i] + (1 - wideShare) * narrow[i])]).map(inside);
    [lab[0][i], lab[1][i], lab[2][i]] = huntLab(times(xyzFromRgb, rgb));
  }
  const deviation = 0.5 * featureWidth * pixelsPerDegree;
  const reach = Math.ceil(3 * deviation);
  const round = bell(1 / (2 * deviation ** 2), reach);
  const first = balanced(round.map((value, i) => -(i - reach) * value));
  const second = balanced(round.map((value, i) => ((i - reach) ** 2 / deviation ** 2 - 1) * value));
  const magnitude = (derivative) => {
    const dx = convolve(opponent[0], width, height, derivative, normalised(round));
    const dy = convolve(opponent[0], width, height, normalised(round), derivative);
    return dx.map((value, i) => Math.hypot(value, dy[i]));
  };
  return {lab, edge: magnitude(first), point: magnitude(second)};
}

/** FLIP per pixel, 0 to 1, of two images given as three planes of linear sRGB each, in 0..1. */
export function flipMap(a, b, width, height) {
  const [p, q] = [features(a, width, height), features(b, width, height)];
  const distance = (l, m, n) => (Math.abs(l) + Math.hypot(m, n)) ** colourExponent;
  const [green, blue] = [huntLab(times(xyzFromRgb, [0, 1, 0])), huntLab(times(xyzFromRgb, [0, 0, 1]))];
  const largest = distance(...green.map((value, i) => value - blue[i]));
  const knee = compressedShare * largest;
  return Float32Array.from({length: width * height}, (_, i) => {
    const difference = distance(...[0, 1, 2].map((c) => p.lab[c][i] - q.lab[c][i]));
    const colour = difference < knee ? (compressedTo / knee) * difference : compressedTo + ((difference - knee) / (largest - knee)) * (1 - compressedTo);
    if (!(colour > 0)) return 0;
    const feature = Math.sqrt(Math.SQRT1_2 * Math.max(Math.abs(p.edge[i] - q.edge[i]), Math.abs(p.point[i] - q.point[i])));
    return Math.min(colour ** (1 - Math.min(feature, 1)), 1);
  });
}
