// A story as `subpixel pixel --json` tells it, of a pixel with four samples: fragment 0 and 9 show, 1 to 6 leave nothing.

const surface = {normal: [0, 0, 1], albedo: [0.5, 0.25, 0.125], roughness: 0.8, metallic: 0, emissive: [0, 0, 0]};
const triangle = (number) => ({draw: 3, instance: 0, triangle: 17 + number, material: 1, material_name: '<b>leaf</b>', back_face: number === 9});
const fragment = (number, covers, alpha, passes) => ({number, triangle: triangle(number), covers, ...(alpha ? {alpha_leaves: alpha} : {}), passes, plane: {depth: 0.25, dx: 0, dy: 0}, shaded_at: [0, 0], surface});
const pattern = [[0.125, -0.375], [-0.375, -0.125], [0.375, 0.125], [-0.125, 0.375]].map((at, sample) => ({at, fragment: [0, 0, 9, null][sample], depth: [0.25, 0.25, 0.5, null][sample]}));
const fragments = [fragment(0, '0x3', null, '0x3'), ...[1, 2, 3, 4].map((number) => fragment(number, '0xf', '0x0', '0x0')), fragment(5, '0x3', null, '0x0'), fragment(6, '0x0', null, '0x0'), fragment(9, '0xf', '0x4', '0x4')];
const result = (radiance, executions) => ({radiance, display: radiance.map((value) => value ** 0.5), executions});

/** Of the technique and parameters that were asked for, at pixel x, y. */
export function madeUpStory({technique, parameters, frame, x, y}) {
  const story = {technique, parameters, samples: 4, pattern, fragments, maps: {merges: 1, order_errors: 0},
    steps: [{fragment: 0, kind: 'stored', what: 'stored as surface 0'}, ...[1, 2, 3, 4].map((number) => ({fragment: number, kind: 'transparent', what: 'dropped: alpha leaves no sample'})),
      {fragment: 5, kind: 'hidden', what: 'dropped: behind'}, {fragment: 9, kind: 'merged', what: 'merged into surface 0, against the parameters: depths 1 to 2 apart from its 3 to 4'}],
    surfaces: [{slot: 0, covers: '0x7', weight: 3, depth_of: 'distance along the view', nearest: 1, farthest: 4, surface: {...surface, emissive: [1, 0, 0], metallic: 0.5}}],
    executions: [{of: 0, samples: '0x7', weight: 3, value: [0.5, 0.25, 0.125]}], resolve: {what: 'the mean of 4 samples: 3 of what is lit, 1 of the sky'}, result: result([0.25, 0.25, 0.25], 1)};
  const {steps: _steps, surfaces: _surfaces, ...plain} = story;
  const msaa = {...plain, technique: 'msaa', parameters: {samples: 4}, executions: [0, 1, 2].map((sample) => ({of: sample, samples: `0x${(1 << sample).toString(16)}`, weight: 1, value: [0.1, 0.2, 0.3]})), result: result([0.09, 0.16, 0.25], 3)};
  return {capture: 'Made up', frame, pixel: [x, y], size: [160, 90], device: 'none', stories: [story, msaa],
    reference: {samples: 8, result: result([0.36, 0.04, 0.01]), shadings: [0, 9].map((number, i) => ({turn: i, at: [0.25 * i, -0.25], samples: 2 + i, radiance: [0.4, 0.2, 0.1], triangle: triangle(number)}))}};
}
