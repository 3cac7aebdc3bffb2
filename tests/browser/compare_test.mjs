// The viewer over made-up results whose every pixel is known: what it shows of them, by clicks and keys.
//
//   node compare_test.mjs [--screenshots DIR]
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import {tmpdir} from 'node:os';
import {parseArgs} from 'node:util';
import {Browser} from './browser.mjs';
import {error, executions, fromHalf, image, MadeUpService, radiance, reference, toHalf, wrong} from './made_up_service.mjs';

const {values: options} = parseArgs({options: {screenshots: {type: 'string'}}});
const browser = new Browser(options.screenshots);
const [width, height, frames, rows] = [160, 90, 12, 4];
const service = new MadeUpService({1: {width, height, frames, rows}, 2: {width, height, frames, rows: 3}, 3: {width, height, frames: 2, rows: 2, status: 'running'},
  4: {width, height, frames: 1, rows: 2, status: 'failed', reason: 'the driver lost the device'}});
service.nights = {1: {lights: 2}, 2: {lights: 9}};
let page;

const view = () => page.locator('.view');
const settled = () => page.waitForFunction(() => document.querySelector('.view')?.getAttribute('aria-busy') === 'false' && !document.querySelector('[aria-busy="true"]'));
const keys = async () => {
  await settled();
  return view().getAttribute('data-keys');
};
// Results come one after another: what can be shown of the layers asked for is shown meanwhile.
const expectKeys = async (wanted) => {
  await page.waitForFunction((text) => {
    const shown = document.querySelector('.view');
    return shown?.getAttribute('aria-busy') === 'false' && shown.dataset.keys === text;
  }, wanted, {timeout: 10_000}).catch(() => {});
  assert.equal(await keys(), wanted);
};
const parameters = () => new URLSearchParams(new URL(page.url()).hash.split('?')[1] ?? '');
const awaitParameter = (name, value) => page.waitForFunction(([n, v]) => new URLSearchParams(location.hash.split('?')[1] ?? '').get(n) === v, [name, value]);
// The address follows what is done a moment later.
const addressed = () => page.waitForFunction(() => !document.body.dataset.address);
const expectNear = async (name, wanted, tolerance) => {
  await page.waitForFunction(([n, w, t]) => Math.abs(Number(new URLSearchParams(location.hash.split('?')[1] ?? '').get(n)) - w) < t, [name, wanted, tolerance], {timeout: 10_000}).catch(() => {});
  const actual = Number(parameters().get(name));
  assert.ok(Math.abs(actual - wanted) < tolerance, `${name}: ${actual} is not ${wanted}`);
};
const srgb = (v) => 255 * (v <= 0 ? 0 : v >= 1 ? 1 : v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
const half = (value) => fromHalf(toHalf(value));
// The colour of made_up_service.mjs' palettes.
const ramp = (name, t) => {
  const points = service.palettes[name].map((colour) => [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)));
  const at = Math.min(Math.max(t, 0), 1) * (points.length - 1);
  const below = Math.min(Math.floor(at), points.length - 2);
  return points[below].map((low, c) => low + (at - below) * (points[below + 1][c] - low));
};

// Where a pixel of the image is on the page: its middle. The view says where it is by its address.
async function place(x, y, cell = 0) {
  await addressed();
  return page.locator('.view-canvas').evaluate((canvas, [px, py, w, h, index]) => {
    const box = canvas.getBoundingClientRect();
    const query = new URLSearchParams(location.hash.split('?')[1] ?? '');
    const number = document.querySelectorAll('.view-labels .view-label').length;
    const side = query.get('mode') === 'side';
    let [columns, count] = [1, 1];
    if (side) {
      const fits = Array.from({length: number}, (_, i) => Math.min(box.width / (i + 1) / w, box.height / Math.ceil(number / (i + 1)) / h));
      columns = fits.indexOf(Math.max(...fits)) + 1;
      count = Math.ceil(number / columns);
    }
    const [cw, ch] = [box.width / columns, box.height / count];
    const scale = Number(query.get('zoom')) || Math.min(cw / w, ch / h);
    const [cx, cy] = [query.has('x') ? Number(query.get('x')) : w / 2, query.has('y') ? Number(query.get('y')) : h / 2];
    return {x: box.left + (index % columns) * cw + cw / 2 + (px + 0.5 - cx) * scale, y: box.top + Math.floor(index / columns) * ch + ch / 2 + (py + 0.5 - cy) * scale};
  }, [x, y, width, height, cell]);
}

async function colourOf(x, y, cell = 0) {
  await settled();
  const at = await place(x, y, cell);
  return page.locator('.view-canvas').evaluate((canvas, point) => {
    const box = canvas.getBoundingClientRect();
    return [...canvas.getContext('2d').getImageData(Math.floor((point.x - box.left) * canvas.width / box.width), Math.floor((point.y - box.top) * canvas.height / box.height), 1, 1).data].slice(0, 3);
  }, at);
}

function near(actual, expected, tolerance, why) {
  assert.ok(expected.every((value, i) => Math.abs(actual[i] - value) <= tolerance), `${why}: ${actual} is not ${expected.map((v) => v.toFixed(2))}`);
}

const open = async (hash) => {
  await page.goto('about:blank');
  await page.goto(`${service.url}/${hash}`);
};
const openRun = async (hash = '#/runs/1') => {
  await open(hash);
  await page.locator('.view[data-shown]').waitFor();
  await settled();
};
const inSight = async () => {
  const scroll = () => page.locator('.view-stage').evaluate((stage) => stage.scrollIntoView({block: 'center'}));
  await scroll();
  await settled();  // what is drawn later above it may move it
  await scroll();
};
const press = async (...names) => {
  for (const name of names) await page.keyboard.press(name);
  await settled();
};

// The page that `press` writes, opened by itself; it may ask for nothing.
const openReport = async (name, press) => {
  const download = page.waitForEvent('download');
  await press();
  const path = join(tmpdir(), `subpixel-${name}-${process.pid}.html`);
  await (await download).saveAs(path);
  const other = await browser.context.newPage();
  const asked = [];
  other.on('request', (request) => asked.push(request.url()));
  await other.goto(`file://${path}`);
  assert.deepEqual(asked.filter((url) => !url.startsWith('file:') && !url.startsWith('data:')), []);
  return other;
};

const tests = [
  ['the service starts', async () => {
    await service.start();
    await browser.open();
    page = browser.page;
    await openRun();
  }],

  // Data, not colours ---------------------------------------------------------------------------------------------
  ['the values under the pointer are the true ones of every layer', async () => {
    await openRun('#/runs/1?row=2&layers=*:image,*:hdr,*:error,*:flip,*:shading,*:reference&frame=1');
    await inSight();
    for (const [x, y] of [[42, 25], [3, 3], [100, 60]]) {
      const at = await place(x, y);
      await page.mouse.move(at.x, at.y);
      await page.waitForFunction(([px, py]) => {
        const {x: vx, y: vy} = JSON.parse(document.querySelector('.view').dataset.values ?? '{}');
        return vx === px && vy === py;
      }, [x, y]);
      const {values} = JSON.parse(await view().getAttribute('data-values'));
      const rgb = (of) => [0, 1, 2].map(of);
      const expected = [rgb((c) => image(x, y, c, 1, 2) / 255), rgb((c) => half(radiance(x, y, c, 1, 2))), [half(error(x, y, 2))], [Math.fround(error(x, y, 2) / 2)],
        [executions(x, y, 2)], rgb((c) => reference(x, y, c, 1) / 255)];
      expected.forEach((layer, i) => near(values[i], layer, 1e-7, `layer ${i + 1} at ${x}, ${y}`));
    }
    const at = await place(3, 3);
    await page.mouse.move(at.x, at.y);
    await page.locator('.readout').getByText('70,000 executions').waitFor();
  }],

  ['maps are coloured by the page: range, logarithm, palette', async () => {
    await page.getByRole('button', {name: 'Error map'}).click();
    near(await colourOf(42, 25), ramp('magma', half(60 / 255) / 0.25), 2, 'error in magma');
    near(await colourOf(10, 10), ramp('magma', 0), 2, 'no error');
    await page.getByText('Exposure, tone and false colour').click();
    await page.getByLabel('To', {exact: true}).fill('0.5');
    await page.getByLabel('To', {exact: true}).press('Tab');
    near(await colourOf(42, 25), ramp('magma', half(60 / 255) / 0.5), 2, 'the range to 0.5');
    await page.getByLabel('Colours').selectOption('viridis');
    near(await colourOf(42, 25), ramp('viridis', half(60 / 255) / 0.5), 2, 'viridis');
    await page.getByLabel('logarithmic', {exact: true}).first().check();
    near(await colourOf(42, 25), ramp('viridis', Math.log(half(60 / 255) / 0.0005) / Math.log(1000)), 2, 'logarithm');
    assert.match(await page.locator('.legend').first().innerText(), /0\.5/);
    await page.getByRole('button', {name: 'Reset'}).click();
    near(await colourOf(42, 25), ramp('magma', half(60 / 255) / 0.25), 2, 'as before');
  }],

  ['linear images have exposure, tone, single channels and false colour', async () => {
    await page.getByRole('button', {name: 'Linear images'}).click();
    await press('f');
    const light = (c) => half(radiance(100, 60, c, 1, 2));
    near(await colourOf(100, 60), [0, 1, 2].map((c) => srgb(light(c))), 1.5, 'clamped');
    await press('E', 'E', 'E', 'E');
    near(await colourOf(100, 60), [0, 1, 2].map((c) => srgb(light(c) / 4)), 1.5, 'two stops darker');
    await press('t');
    near(await colourOf(100, 60), [0, 1, 2].map((c) => srgb(light(c) / 4 / (1 + light(c) / 4))), 1.5, 'Reinhard');
    await press('t', 't', 'c');
    near(await colourOf(100, 60), Array(3).fill(srgb(light(0) / 4)), 1.5, 'red alone');
    await press('c', 'o');
    near(await colourOf(100, 60), ramp('viridis', light(1)), 2, 'green in false colour');
    await awaitParameter('false', '1');
    await browser.shot('false-colour');
    await page.getByRole('button', {name: 'Reset'}).click();
  }],

  // Compare -------------------------------------------------------------------------------------------------------
  ['wipe, flip and side by side, by keys', async () => {
    await openRun('#/runs/1?row=3&layers=*:image,*:reference,*:error,1:image');
    await inSight();
    await expectKeys('*:image *:reference');
    near(await colourOf(42, 25), [0, 1, 2].map((c) => image(42, 25, c, 0, 3)), 1, 'left of the line');
    near(await colourOf(100, 60), [0, 1, 2].map((c) => reference(100, 60, c, 0)), 1, 'right of it');
    await press('4');
    await expectKeys('1:image');
    near(await colourOf(42, 25), [0, 1, 2].map((c) => image(42, 25, c, 0, 1)), 1, 'layer 4');
    assert.match(await page.locator('.view-label').innerText(), /4 of 4: msaa/);
    await press('3');
    await expectKeys('*:error');
    await press('s');
    assert.equal(await page.locator('.view-label').count(), 4);
    near(await colourOf(42, 25, 0), [0, 1, 2].map((c) => image(42, 25, c, 0, 3)), 1, 'first cell');
    near(await colourOf(42, 25, 2), ramp('magma', half(60 / 255) / 0.25), 2, 'third cell');
    await press('z', 'z');
    near(await colourOf(42, 25, 3), [0, 1, 2].map((c) => image(42, 25, c, 0, 1)), 1, 'the cells are in step');
    await browser.shot('side-by-side');
    await press('0', 'w');
  }],

  ['layers whose results come late are compared all the same', async () => {
    const rest = service.delay(2);  // rows 0 and 1 of the first frame
    await openRun('#/runs/1?row=3&layers=*:image,*:reference,1:image');
    await page.waitForFunction(() => document.querySelector('.view')?.dataset.keys?.includes('1:image'));
    rest();
    await expectKeys('*:image *:reference');
  }],

  ['difference with gain and sign, by channel and by FLIP', async () => {
    await page.getByLabel('Left', {exact: true}).selectOption('0');
    await page.getByLabel('Right', {exact: true}).selectOption('1');
    await press('d');
    near(await colourOf(42, 25), ramp('magma', 60 / 255 * 4), 2, 'largest difference');
    await press('G', 'G');
    near(await colourOf(42, 25), ramp('magma', 60 / 255), 2, 'gain 1');
    near(await colourOf(10, 10), [0, 0, 0], 1, 'equal');
    await press('n');
    await page.getByLabel('Measure', {exact: true}).selectOption('b');
    near(await colourOf(42, 25), [70, 160, 255].map((v) => v * 60 / 255), 2, 'blue is too dark: blue');
    await page.getByLabel('Measure', {exact: true}).selectOption('r');
    near(await colourOf(42, 25), [255, 150, 40].map((v) => v * 60 / 255), 2, 'red is too bright: orange');
    await page.getByLabel('Measure', {exact: true}).selectOption('flip');
    const [red] = await colourOf(44, 24);
    assert.ok(red > 40, `FLIP sees it: ${red}`);
    near(await colourOf(150, 80), [0, 0, 0], 2, 'and nothing elsewhere');
    await page.getByLabel('Measure', {exact: true}).selectOption('largest');
    await browser.shot('difference');
    await press('w');
  }],

  ['zoom keeps pixels square, with their values; the minimap, dragging and keys move', async () => {
    await press('f', '1');
    for (let i = 0; i < 20 && await page.locator('.scale').innerText() !== '64.0×'; ++i) await press('z');
    await addressed();
    const from = Number(parameters().get('x'));
    const colours = new Set();
    const at = await place(Math.floor(from), Math.floor(Number(parameters().get('y'))));
    for (let dx = -20; dx <= 20; dx += 4) {
      colours.add(String(await page.locator('.view-canvas').evaluate((canvas, point) => {
        const box = canvas.getBoundingClientRect();
        return [...canvas.getContext('2d').getImageData(Math.floor((point.x - box.left) * canvas.width / box.width), Math.floor((point.y - box.top) * canvas.height / box.height), 1, 1).data];
      }, {x: at.x + dx, y: at.y - 29})));
    }
    assert.equal(colours.size, 1, 'one colour all over a pixel');
    await browser.shot('pixel-values');
    await page.locator('.view-canvas').focus();
    await press('ArrowRight');
    await expectNear('x', from + 40 / 64, 0.01);
    const box = await page.locator('.view-canvas').boundingBox();
    await page.mouse.move(box.x + 300, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 300 - 128, box.y + 200, {steps: 4});
    await page.mouse.up();
    await expectNear('x', from + 40 / 64 + 2, 0.05);
    const map = await page.locator('.minimap').boundingBox();
    await page.mouse.click(map.x + map.width * 0.25, map.y + map.height * 0.5);
    await expectNear('x', width * 0.25, 2);
    await press('0');
    assert.equal(await page.locator('.minimap').isVisible(), false);
  }],

  ['two fingers zoom and move the picture', async () => {
    const session = await browser.context.newCDPSession(page);
    const touch = (type, ...points) => session.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
    await inSight();
    await awaitParameter('zoom', null);  // place() goes by the address, which follows a moment later
    const before = (await page.locator('.view-canvas').boundingBox()).width / width;
    const {x, y} = await place(60, 40);
    await page.evaluate(() => document.addEventListener('pixelchosen', () => (window.chosenByFingers = true)));
    await touch('touchStart', [x - 40, y]);
    await touch('touchStart', [x - 40, y], [x + 40, y]);
    for (let apart = 50; apart <= 160; apart += 10) await touch('touchMove', [x - apart, y], [x + apart, y]);
    const fit = Math.min(before, (await page.locator('.view-canvas').boundingBox()).height / height);
    await expectNear('zoom', 4 * fit, 0.1 * fit);
    const zoom = Number(parameters().get('zoom'));
    const under = await place(60, 40);
    near([under.x, under.y], [x, y], 1, 'what is between the fingers stays there');
    const centre = Number(parameters().get('x'));
    for (let by = 8; by <= 64; by += 8) await touch('touchMove', [x - 160 + by, y], [x + 160 + by, y]);
    await touch('touchEnd');
    await expectNear('x', centre - 64 / zoom, 0.1);
    assert.equal(await page.evaluate(() => window.chosenByFingers), undefined, 'two fingers choose no pixel');
    await session.detach();
    await press('0');
  }],

  ['a click tells which pixel was chosen', async () => {
    await page.evaluate(() => document.addEventListener('pixelchosen', ({detail}) => (window.chosen = detail)));
    await addressed();
    const at = await place(60, 30);
    await page.mouse.click(at.x, at.y);
    const {x, y, layer} = await page.evaluate(() => window.chosen);
    assert.deepEqual([x, y, layer.key], [60, 30, '*:image']);
    // By a key: under the pointer.
    const there = await place(100, 60);
    await page.mouse.move(there.x, there.y);
    await page.locator('.view-canvas').focus();
    await page.keyboard.press('Enter');
    assert.deepEqual(await page.evaluate(() => [window.chosen.x, window.chosen.y]), [100, 60]);
    await page.locator('.pixel-story').getByRole('button', {name: 'Close'}).click();
  }],

  ['a box says its error, its share and its lighting executions', async () => {
    await openRun('#/runs/1?row=2&layers=*:image,*:reference,*:error,*:shading');
    await inSight();
    const [from, to] = [await place(wrong.x, wrong.y), await place(wrong.x + 15, wrong.y + 7)];
    await page.keyboard.down('Shift');
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    await page.mouse.move(to.x, to.y, {steps: 5});
    await page.mouse.up();
    await page.keyboard.up('Shift');
    const line = (name) => page.locator('.box-figures tbody tr', {has: page.locator('th', {hasText: name})});
    await line(/shading/).waitFor();
    assert.match(await page.locator('.box-panel h3').innerText(), /Box at 40, 20 of 16×8 pixels/);
    // Half of the box is wrong by 60 of 255, and nothing outside of it.
    assert.match(await line(/^msaa samples=4$/).innerText(), /error\s+0\.1176\s+0\.2353\s+15\.06\s+100\.00 %/);
    assert.match(await line(/error/).innerText(), /100\.00 %/);
    let sum = 0;
    let whole = 0;
    for (let y = 0; y < height; ++y) for (let x = 0; x < width; ++x) {
      whole += executions(x, y, 2);
      if (x >= 40 && x < 56 && y >= 20 && y < 28) sum += executions(x, y, 2);
    }
    const text = await line(/shading/).innerText();
    assert.ok(text.includes(`\t${sum}\t`) && text.includes(`${(100 * sum / whole).toFixed(2)} %`), text);
    await browser.shot('box');
    await page.locator('.view-canvas').focus();
    await press('Shift+ArrowRight');
    await page.getByText('Box at 41, 20 of 16×8 pixels').waitFor();
    await press('x');
    assert.equal(await page.locator('.box-panel').innerText(), '');
  }],

  ['the worst places are listed, and a click goes there', async () => {
    await press('v');
    const places = page.locator('.place');
    await places.first().waitFor();
    assert.equal(await places.count(), 1, 'the wrong pixels lie in one square of 16');
    assert.match(await places.first().getAttribute('aria-label'), /x 40, y 20, 0\.2353/);
    await browser.shot('worst-places');
    // Fifty at most, those of the largest sums.
    const many = await page.evaluate(async () => {
      const {worstPlaces} = await import('/pixel_math.js');
      const values = new Float32Array(320 * 160).map((_, i) => (Math.floor(i / 320 / 16) * 20 + Math.floor((i % 320) / 16)) / 1000);
      const found = worstPlaces(values, 320, 160);
      return {sums: found.map(({sum}) => Math.round(sum)), last: found.at(-1)};
    });
    assert.equal(many.sums.length, 50);
    assert.deepEqual(many.sums, Array.from({length: 50}, (_, i) => Math.round(256 * (199 - i) / 1000)));
    assert.deepEqual([many.last.x, many.last.y], [160, 112]);
    // They follow what is shown.
    await press('k');
    await page.getByRole('heading', {name: 'Worst places of msaa samples=8'}).waitFor();
    assert.match(await places.first().getAttribute('aria-label'), /0\.1569$/);
    await press('j');
    await page.locator('.place[aria-label$="0.2353"]').waitFor();
    const thumbnail = await places.first().locator('canvas').evaluate((canvas) => canvas.toDataURL());
    await press(']');
    await page.waitForFunction((before) => (document.querySelector('.place canvas')?.toDataURL() ?? before) !== before, thumbnail);
    await press('[');
    await places.first().click();
    await awaitParameter('zoom', '16');
    near([Number(parameters().get('x')), Number(parameters().get('y'))], [40.5, 20.5], 0.01, 'centre');
    await press('m');
    assert.equal(await page.locator('.magnifier').isVisible(), true);
    await browser.shot('magnifier');
    await press('m', 'v', '0');
  }],

  ['layers are added and taken away, six at most', async () => {
    await page.locator('.layer-list summary').click();
    await page.getByLabel('of', {exact: true}).selectOption('3');
    await page.getByLabel('layer', {exact: true}).selectOption('flip');
    await page.getByRole('button', {name: 'Add layer'}).click();
    await awaitParameter('layers', '*:image,*:reference,*:error,*:shading,3:flip');
    await page.getByLabel('layer', {exact: true}).selectOption('hdr');
    await page.getByRole('button', {name: 'Add layer'}).click();
    assert.equal(await page.getByRole('button', {name: 'Add layer'}).isDisabled(), true);
    await press('6');
    await expectKeys('3:hdr');
    await page.getByRole('button', {name: 'Take away layer 6'}).click();
    await page.getByRole('button', {name: 'Take away layer 5'}).click();
    await awaitParameter('layers', '*:image,*:reference,*:error,*:shading');
  }],

  // Run -----------------------------------------------------------------------------------------------------------
  ['the table is sorted, filtered and grouped, with bars, the best and what is within its spread', async () => {
    await openRun();
    const labels = () => page.locator('.results .row-select').allInnerTexts();
    const before = await labels();
    assert.deepEqual(before, ['noaa samples=1', 'msaa samples=8', 'msaa samples=4', 'streaming samples=8']);
    await page.locator('[data-sort="mse"]').click();
    assert.deepEqual(await labels(), [...before].reverse());
    assert.equal(await page.locator('th[aria-sort]').getAttribute('aria-sort'), 'ascending');
    await page.locator('[data-sort="mse"]').click();
    assert.deepEqual(await labels(), before);
    await page.locator('[data-sort="mse"]').click();
    const bar = await page.locator('.results tbody tr').nth(1).locator('.cell-bar').first().evaluate((element) => element.style.width);
    assert.equal(bar, '50%');
    assert.equal(await page.locator('td.best').count(), 10, 'one of each measure; the first frame has no flicker');
    assert.deepEqual(await page.locator('td.within').allInnerTexts().then((texts) => texts.length), 2, 'time and its ratio of msaa samples=8');
    await page.getByLabel('filter').fill('msaa 4');
    assert.deepEqual(await labels(), ['msaa samples=4']);
    await page.getByLabel('filter').fill('');
    await page.getByLabel('group').selectOption('technique');
    assert.deepEqual(await page.locator('.group-title').allInnerTexts(), ['noaa', 'msaa', 'streaming']);
    await page.getByLabel('group').selectOption('');
    // Time by pass, stacked on one scale, of all techniques.
    await page.getByText('Time by pass').click();
    const bars = await page.locator('.pass-bars > li').evaluateAll((list) => list.map((line) => [line.querySelector('.pass-title').innerText, ...[...line.querySelectorAll('.pass-bar span')].map((part) => Math.round(parseFloat(part.style.width)))]));
    // Frame 0 takes 20, 21, 36 and 44 ms: 2 of set-up, 10 of shading, the rest geometry.
    assert.deepEqual(bars, [['noaa samples=1 20.0 ms', 5, 18, 23], ['msaa samples=8 21.0 ms', 5, 20, 23], ['msaa samples=4 36.0 ms', 5, 55, 23], ['streaming samples=8 44.0 ms', 5, 73, 23]]);
    await page.getByText('Time by pass').click();
  }],

  ['points select their row, the front and families are drawn, any measure against any other', async () => {
    await settled();  // or the point is drawn anew under the pointer
    await page.locator('.point[data-row="0"] circle').first().click();
    await page.locator('.results tr.selected', {hasText: 'noaa'}).waitFor();
    await awaitParameter('row', '0');
    await page.locator('.point[data-row="2"]').focus();
    await page.keyboard.press('Enter');
    await awaitParameter('row', '2');
    assert.equal(await page.locator('.plot .family').count(), 1);
    assert.equal((await page.locator('.plot .front').getAttribute('points')).split(' ').length, 4);
    await page.getByLabel('Measure across').selectOption('executions');
    await page.locator('.plot[data-drawn="executions mse"]').waitFor();
    const download = page.waitForEvent('download');
    await page.locator('.plot').locator('..').getByRole('button', {name: 'SVG'}).click();
    const file = await (await download).path();
    assert.match(readFileSync(file, 'utf8'), /^<svg[^>]*xmlns=.*msaa samples=4/s);
  }],

  ['labels of points never overlap, however close the points are', async () => {
    const overlaps = (selector) => page.evaluate((where) => {
      const boxes = [...document.querySelectorAll(`${where} .point text`)].map((text) => [text.textContent, text.getBoundingClientRect()]);
      const pairs = [];
      boxes.forEach(([a, p], i) => boxes.slice(i + 1).forEach(([b, q]) => {
        if (p.left < q.right && q.left < p.right && p.top < q.bottom && q.top < p.bottom) pairs.push(`${a} over ${b}: ${[p, q].map(({left, right, top, bottom}) => [left, right, top, bottom].map((v) => v.toFixed(1)).join(' ')).join(' and ')}`);
      }));
      return {labels: boxes.length, pairs};
    }, selector);
    const own = await overlaps('.plot');
    assert.deepEqual(own, {labels: 4, pairs: []});
    // Rows all over the plot, in a heap in its corner, and all in one point.
    for (const [number, spread, wanted] of [[40, 1, 30], [24, 0.02, 20], [40, 0, 30], [400, 0.3, 30]]) {
      const drawn = await page.evaluate(async ([count, width]) => {
        const {scatterSvg} = await import('/scatter.js');
        const rows = Array.from({length: count}, (_, i) => ({technique: 'streaming', family: i, run: 1, select: `${i}`, label: `streaming samples=${8 + i} surfaces=${i % 4 + 1}`,
          summary: {total: 100 + width * (i * 37 % 101), mse: 1 + width * (i * 53 % 97)}}));
        const draw = () => scatterSvg(rows, {x: 'total', y: 'mse', logX: false, logY: false, baseline: null}, null);
        document.querySelector('.crowd')?.remove();
        const crowd = document.createElement('div');
        crowd.className = 'crowd';
        crowd.append(draw());
        document.body.append(crowd);
        return crowd.innerHTML === Object.assign(document.createElement('div'), {innerHTML: draw().outerHTML}).innerHTML;
      }, [number, spread]);
      assert.ok(drawn, 'the same rows are drawn the same');
      const {labels: shown, pairs} = await overlaps('.crowd');
      assert.deepEqual(pairs, []);
      assert.ok(shown >= wanted, `${shown} of ${number} labels in a spread of ${spread} found a place`);
    }
    await page.evaluate(() => document.querySelector('.crowd').remove());
  }],

  ['over frames: lines, a click chooses the frame, playback', async () => {
    await page.locator('.lines canvas').waitFor();
    await page.getByLabel('Measure over frames').selectOption('flicker');
    await page.locator('.lines[data-drawn="flicker"]').waitFor();
    const drawn = () => page.getByRole('img', {name: 'A measure over the frames'}).locator('canvas').evaluate((canvas) => canvas.toDataURL());
    const plots = new Set();
    for (const measure of ['mse', 'flip', 'fitted', 'executions', 'total', 'flicker']) {
      await page.getByLabel('Measure over frames').selectOption(measure);
      await page.locator(`.lines[data-drawn="${measure}"]`).waitFor();
      await page.waitForTimeout(50);
      plots.add(await drawn());
    }
    assert.equal(plots.size, 6, 'each is another plot');
    await page.locator('.lines').scrollIntoViewIfNeeded();
    const box = await page.locator('.lines .u-over').boundingBox();
    await page.mouse.move(box.x + box.width - 3, box.y + box.height / 2);
    await page.waitForTimeout(100);
    await page.mouse.click(box.x + box.width - 3, box.y + box.height / 2);
    await awaitParameter('frame', '11');
    assert.equal(await page.locator('.frame-number').innerText(), '11');
    await page.locator('.series-key').first().click();
    assert.equal(await page.locator('.series-key[aria-pressed="false"]').innerText(), 'noaa samples=1');
    await browser.shot('run-1360');
    await press('[');
    await awaitParameter('frame', '10');
    await page.keyboard.press('p');
    const seen = new Set();
    const ends = Date.now() + 20_000;
    while (seen.size < 4 && Date.now() < ends) seen.add(await page.locator('.frame-number').innerText());
    assert.ok(seen.size >= 4, `played ${[...seen]}`);
    await page.keyboard.press('p');
    assert.equal(await page.getByRole('button', {name: 'Play'}).isVisible(), true);
  }],

  ['two runs of one capture are beside each other', async () => {
    await page.getByLabel('beside').selectOption('2');
    await page.locator('.results .row-select', {hasText: '(run 2)'}).nth(2).waitFor();
    assert.equal(await page.locator('.results .row-select').count(), rows + 3);
    await awaitParameter('with', '2');
    await page.getByLabel('group').selectOption('run');
    assert.deepEqual(await page.locator('.group-title').allInnerTexts(), ['Run 1', 'Run 2']);
    await page.locator('.layer-list summary').click();
    await page.getByLabel('of', {exact: true}).selectOption({label: 'noaa samples=1 (run 2)'});
    await page.getByRole('button', {name: 'Add layer'}).click();
    await press('5');
    await expectKeys('4:image');
    assert.match(await page.locator('.view-label').innerText(), /run 2/);
    await browser.shot('two-runs');
  }],

  ['frames follow each other in the same elements', async () => {
    await openRun('#/runs/1?frame=1');
    await page.locator('.lines canvas').waitFor();
    const labels = () => page.locator('.results .row-select').allInnerTexts();
    const figures = () => page.locator('.results').innerText();
    const before = {labels: await labels(), figures: await figures()};
    const added = await page.evaluate(async (swaps) => {
      const view = document.querySelector('.view');
      let [nodes, layouts] = [0, 0];
      const of = (node) => 1 + [...node.childNodes].reduce((sum, child) => sum + of(child), 0);
      const observer = new MutationObserver((records) => records.forEach(({addedNodes}) => addedNodes.forEach((node) => (nodes += of(node)))));
      const ask = Element.prototype.getBoundingClientRect;
      Element.prototype.getBoundingClientRect = function () {
        ++layouts;
        return ask.call(this);
      };
      observer.observe(document.getElementById('main'), {childList: true, subtree: true});
      document.querySelector('.plot').scrollIntoView();  // its points are drawn for each frame only while they are seen
      document.querySelector('.results').scrollIntoView();
      for (let i = 0; i < swaps; ++i) {
        const shown = view.dataset.shown;
        dispatchEvent(new KeyboardEvent('keydown', {key: ']'}));
        while (view.dataset.shown === shown) await new Promise(requestAnimationFrame);
      }
      observer.disconnect();
      Element.prototype.getBoundingClientRect = ask;
      return {nodes: nodes / swaps, layouts};
    }, 8);
    // Three, and more where the machine is so busy that what is out of sight has its turn between frames; made anew it was 658.
    assert.ok(added.nodes < 150, `${added.nodes} nodes are made for a frame`);
    assert.equal(added.layouts, 0, 'the page is laid out on demand');
    await page.waitForFunction((text) => document.querySelector('.results').innerText !== text, before.figures);
    assert.deepEqual(await labels(), before.labels);
  }],

  // One pixel's story ---------------------------------------------------------------------------------------------
  ["a pixel's story: samples, fragments with masks, steps, what was kept, lit and resolved, beside msaa and the reference", async () => {
    await openRun('#/runs/1?row=3&layers=*:image,1:image,*:reference&mode=side&frame=4');
    await inSight();
    service.busy = 1;  // the service tells somebody else's first
    const at = await place(60, 30, 1);
    await page.mouse.click(at.x, at.y);
    const story = page.locator('.pixel-story');
    await story.locator('.story').nth(2).waitFor();
    browser.forgive('503');
    await awaitParameter('pixel', '60,30,1,4');
    const {technique, x, y, frame, samples, point_lights: lights} = service.stories.at(-1);
    assert.deepEqual([technique, x, y, frame, samples, lights], ['msaa:samples=8', '60', '30', '4', '4', '5'], 'of the layer that was clicked');
    const cells = (caption, article = 0) => story.locator('.story').nth(article).locator('table', {has: page.locator('caption', {hasText: caption})}).locator('tbody tr:not([hidden])')
      .evaluateAll((lines) => lines.map((line) => [...line.children].map((cell) => cell.innerText.trim())));
    // What came out of all three beside each other.
    const glance = await story.locator('.glance tbody tr').allInnerTexts();
    assert.match(glance[0], /msaa\s+0\.500 0\.500 0\.500\s+0\.2500 0\.2500 0\.2500\s+1\s+mean of 4 samples: 3 of what is lit, 1 of the sky/);
    assert.match(glance[2], /reference\s+0\.600 0\.200 0\.100.*mean of 8 samples/);
    assert.equal(await story.locator('.glance .swatch').nth(2).evaluate((swatch) => swatch.style.background), 'rgb(153, 51, 26)');
    // Each sample with its fragment, triangle, draw, material and depth.
    const leaf = (number) => `draw 3, instance 0, triangle ${17 + number}, <b>leaf</b> (material 1)${number === 9 ? ', back face' : ''}`;
    assert.deepEqual(await cells('Samples'), [['0', '0.125 -0.375', '0', leaf(0), '0.250000'], ['1', '-0.375 -0.125', '0', leaf(0), '0.250000'], ['2', '0.375 0.125', '9', leaf(9), '0.500000'], ['3', '-0.125 0.375', 'sky', '', '']]);
    assert.equal(await story.locator('.pattern').first().locator('circle').count(), 4);
    assert.equal(await story.locator('b', {hasText: 'leaf'}).count(), 0, "a material's name is text");
    // Fragments in order with masks; those of which nothing is left are folded, and open.
    const shown = await cells('Fragments');
    assert.deepEqual(shown.map((row) => row[0]), ['0', '5 fragments (1 to 5): alpha leaves no sample of 4, 1 behind what came before', '9']);
    assert.deepEqual(shown[2].slice(1, 5), [leaf(9), '0xf', '0x4', '0x4']);
    assert.equal(await story.locator('.mask-picture[aria-label="1 of 4 samples: 2"]').first().isVisible(), true);
    await story.getByRole('button', {name: /^5 fragments \(1 to 5\): alpha/}).click();
    assert.deepEqual((await cells('Fragments')).map((row) => row[0]).filter((text) => text.length === 1), ['0', '1', '2', '3', '4', '5', '9']);
    await story.getByText('1 more reach the pixel and cover none of its samples').waitFor();
    // Steps, what was kept, lit and resolved.
    assert.deepEqual((await cells('What was done')).map((row) => row.at(-1)), ['stored as surface 0', '5 fragments (1 to 5) dropped: alpha leaves no sample; dropped: behind',
      'merged into surface 0, against the parameters: depths 1 to 2 apart from its 3 to 4']);
    assert.equal(await story.locator('strong.against').innerText(), 'against the parameters');
    assert.deepEqual(await cells('Kept'), [['0', '0x7', '3', '1.0000 to 4.0000', '0.00 0.00 1.00', '0.50 0.25 0.13', '0.80', '0.50', '1.000 0.000 0.000']]);
    assert.deepEqual(await cells('Lighting'), [['0', '0x7', '3', '0.5000 0.2500 0.1250']]);
    assert.deepEqual((await cells('Lighting', 1)).map((row) => row.slice(0, 2)), [['0', '0x1'], ['1', '0x2'], ['2', '0x4']]);
    await story.locator('.story').nth(1).getByText('The same fragments came as to msaa.').waitFor();
    assert.match(await story.locator('.story').first().innerText(), /Resolve: the mean of 4 samples.*Maps here: merges 1, order errors 0/s);
    assert.deepEqual(await cells('Shading samples', 2), [[leaf(9), '3', '1', '0.4000 0.2000 0.1000'], [leaf(0), '2', '1', '0.4000 0.2000 0.1000'], ['sky', '3', '', '']]);
    await browser.shot('story');
  }],

  ['the pixel is marked, its neighbours are one key away, and the story is there as JSON', async () => {
    const story = page.locator('.pixel-story');
    await press('f', '1', '0');
    await inSight();
    await addressed();
    const white = async (x, y) => page.locator('.view-canvas').evaluate((canvas, point) => {
      const box = canvas.getBoundingClientRect();
      const [px, py] = [(point.x - box.left) * canvas.width / box.width, (point.y - box.top) * canvas.height / box.height];
      const {data} = canvas.getContext('2d').getImageData(Math.round(px) - 9, Math.round(py) - 9, 19, 19);
      return Array.from({length: 361}, (_, i) => data[4 * i] === 255 && data[4 * i + 1] === 255 && data[4 * i + 2] === 255).filter(Boolean).length;
    }, await place(x, y));
    assert.ok(await white(60, 30) > 20, 'a frame around the pixel');
    await story.getByRole('button', {name: 'The pixel to the right'}).focus();
    await page.keyboard.press('Enter');
    await awaitParameter('pixel', '61,30,1,4');
    await story.getByRole('heading', {name: 'Pixel 61, 30 of frame 4'}).waitFor();
    await page.waitForFunction(() => !document.querySelector('.pixel-story').ariaBusy);
    assert.equal(await page.evaluate(() => document.activeElement.dataset.step), 'to the right', 'the key goes on');
    assert.ok(await white(61, 30) > 20);
    const download = page.waitForEvent('download');
    await story.getByRole('button', {name: 'JSON of the story'}).click();
    const file = await download;
    assert.equal(file.suggestedFilename(), 'pixel-61-30-frame-4.json');
    const {pixel, stories} = JSON.parse(readFileSync(await file.path(), 'utf8'));
    assert.deepEqual([pixel, stories.length], [[61, 30], 2]);
    for (const theme of ['dark', 'light']) {
      await page.evaluate((value) => (document.documentElement.dataset.theme = value), theme);
      assert.deepEqual(await browser.violations(), [], `a story, ${theme}`);
    }
    const wide = page.viewportSize();
    await page.setViewportSize({width: 390, height: 844});
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'no sideways scrolling on a phone');
    assert.deepEqual(await browser.violations(), [], 'a story on a phone');
    await browser.shot('story-phone');
    await page.setViewportSize(wide);
    await page.evaluate(() => delete document.documentElement.dataset.theme);
    service.missing = true;
    await story.getByRole('button', {name: 'The pixel above'}).click();
    await story.locator('.problem', {hasText: 'no capture of this content'}).waitFor();
    service.missing = false;
    browser.forgive('404');
    await story.getByRole('button', {name: 'Close'}).click();
    await awaitParameter('pixel', null);
    assert.equal(await white(61, 30), 0, 'no mark without a story');
  }],

  // Nights ----------------------------------------------------------------------------------------------------------
  ["a night's cells are walked by keys; one's frame, layers, zoom, box and pixel are in its address, which restores them", async () => {
    await open('#/nights/2');
    await page.locator('.cell.failed').waitFor();
    const pressed = () => page.locator('.cell[aria-pressed="true"]').getAttribute('aria-label');
    await page.keyboard.press('a');
    await page.getByRole('heading', {name: 'made up, msaa:samples=8'}).waitFor();
    assert.equal(await pressed(), 'made up, msaa:samples=8: failed');
    await page.keyboard.press('j');
    await page.getByRole('heading', {name: 'made up, streaming:samples=8'}).waitFor();
    await page.getByText('It was not replayed.').waitFor();
    await page.keyboard.press('k');
    await page.getByRole('heading', {name: 'made up, msaa:samples=8'}).waitFor();
    await awaitParameter('cell', '21');
    assert.equal(await page.getByLabel('frame', {exact: true}).inputValue(), '0', 'the first frame that differs');
    await page.keyboard.press(']');
    await awaitParameter('frame', '1');
    await page.locator('.view[data-shown]').waitFor();
    await page.getByLabel('and of').selectOption('1');
    await page.getByRole('option', {name: '3: night 1'}).first().waitFor({state: 'attached'});
    await inSight();
    await page.locator('.view-canvas').focus();
    await press('3', 'z', 'z', 'x');
    await inSight();
    const at = await place(80, 44);
    await page.mouse.click(at.x, at.y);
    await page.locator('.pixel-story .story').nth(2).waitFor();
    const {technique, frame, width: w, point_lights: lights} = service.stories.at(-1);
    assert.deepEqual([technique, frame, w, lights], ['msaa:samples=8', '1', '160', '9'], "of tonight's technique, with the night's lights");
    await addressed();
    const state = () => page.evaluate(() => ({keys: document.querySelector('.view').dataset.keys, scale: document.querySelector('.scale').innerText, label: document.querySelector('.view-label').innerText,
      cell: document.querySelector('.cell[aria-pressed="true"]').dataset.cell, box: document.querySelector('.box-panel h3')?.innerText, story: document.querySelector('.pixel-story h2')?.innerText, gates: document.querySelector('.gates').innerText}));
    await page.locator('.box-panel h3').waitFor();
    const [before, address] = [await state(), page.url()];
    assert.match(before.keys, /^night 1:image$/);
    assert.match(before.story, /of frame 1$/);
    await open(address.slice(service.url.length + 1));
    await page.locator('.box-panel h3').waitFor();
    await page.locator('.pixel-story .story').nth(2).waitFor();
    await settled();
    assert.deepEqual(await state(), before);
    await addressed();
    assert.equal(page.url(), address);
    await browser.shot('night-cell');
    for (const theme of ['dark', 'light']) {
      await page.evaluate((value) => (document.documentElement.dataset.theme = value), theme);
      assert.deepEqual(await browser.violations(), [], `a night, ${theme}`);
    }
    await page.evaluate(() => delete document.documentElement.dataset.theme);
  }],

  ["a night's report has its grid, the cell with its pictures, and the story", async () => {
    const other = await openReport('night', () => page.keyboard.press('r'));
    const text = await other.locator('body').innerText();
    for (const words of ['Night 2 of nightly: failed', 'made up, msaa:samples=8: failed', '<i>failed</i>', 'Box at', 'Pixel 80, 44 of frame 1', 'merged into surface 0, against the parameters']) assert.ok(text.includes(words), words);
    assert.deepEqual(await other.locator('figure img').evaluateAll((images) => images.map((image) => image.naturalWidth > 100)), [true, true, true, true], 'baseline, tonight, difference and the view');
    assert.equal(await other.locator('button, input, select, script, [href^="#"]').count(), 0, 'nothing to press');
    if (options.screenshots) await other.screenshot({path: join(options.screenshots, 'night-report.png'), fullPage: true});
    await other.close();
    // A closed cell's pixel goes with it, and keys of the night with the night.
    await page.keyboard.press('[');
    await awaitParameter('pixel', null);
    await awaitParameter('frame', '0');
    await page.keyboard.press('i');
    await page.getByRole('heading', {name: 'Nights', exact: true}).waitFor();
    await page.keyboard.press('?');
    assert.doesNotMatch(await page.getByRole('dialog').innerText(), /next cell/);
    await page.keyboard.press('Escape');
  }],

  // Report --------------------------------------------------------------------------------------------------------
  ['the address restores the view whole', async () => {
    await openRun('#/runs/1');
    await inSight();
    await page.locator('[data-sort="flip"]').click();
    await page.getByLabel('group').selectOption('technique');
    await page.locator('h1').click();
    await inSight();
    const at = await place(60, 30);
    await page.mouse.click(at.x, at.y);  // of frame 0 and the first technique, whatever is chosen later
    await page.locator('h1').click();
    await press(']', ']', 'd', 'g', 'z', 'z', 'x', 'a', 'k', 'v');
    await page.locator('.place').first().waitFor();
    await page.locator('.series-key').nth(1).click();
    await settled();
    await addressed();
    const address = page.url();
    const state = () => page.evaluate(() => ({table: document.querySelector('.results').innerText, keys: document.querySelector('.view').dataset.keys, scale: document.querySelector('.scale').innerText,
      frame: document.querySelector('.frame-number').innerText, story: document.querySelector('.pixel-story h2')?.innerText, box: document.querySelector('.box-panel h3')?.innerText, label: document.querySelector('.view-label').innerText,
      worst: document.querySelector('.worst-panel h3')?.innerText, lines: document.querySelector('.series-key[aria-pressed="false"]')?.innerText}));
    await page.locator('.box-panel h3').waitFor();
    const before = await state();
    assert.ok(before.worst && before.lines === 'msaa samples=8', JSON.stringify(before));
    assert.ok(before.box && before.label.includes('×8') && before.frame === '2' && before.story === 'Pixel 60, 30 of frame 0', JSON.stringify(before));
    await open(address.slice(service.url.length + 1));
    await page.locator('.box-panel h3').waitFor();
    await page.locator('.place').first().waitFor();
    await page.locator('.series-key').nth(1).waitFor();
    await settled();
    await page.waitForFunction((table) => document.querySelector('.results').innerText === table, before.table);
    assert.deepEqual(await state(), before);
    assert.match(service.requests.findLast((path) => path.endsWith('/pixel')) ?? '', /pixel/);
    // Closed, it is gone from the address as well.
    await page.locator('.pixel-story').getByRole('button', {name: 'Close'}).click();
    await awaitParameter('pixel', null);
    await open(`${page.url().slice(service.url.length + 1)}&pixel=1,2,99,0`);
    await settled();
    assert.equal(await page.locator('.pixel-story').isVisible(), false, 'of a technique that the run does not have');
  }],

  ['one click writes a page by itself, without network', async () => {
    await open(`${page.url().slice(service.url.length + 1).replace(/&pixel=[^&]*/, '')}&pixel=1,2,0,0`);
    await page.locator('.pixel-story .story').first().waitFor();
    await page.locator('.plot .point').first().waitFor();
    await page.locator('.box-panel h3').waitFor();
    await press('w');
    await page.locator('.place').first().waitFor();
    const other = await openReport('report', () => page.getByRole('button', {name: 'Report'}).click());
    assert.ok(await other.locator('figure img').first().evaluate((element) => element.naturalWidth > 500));
    assert.equal(await other.locator('svg[viewBox="0 0 900 420"], svg[aria-label$="over frames"]').count(), 2);
    const text = await other.locator('body').innerText();
    for (const words of ['Box at', 'Worst places of', 'Pixel 1, 2 of frame 0', 'Resolve: the mean of 4 samples']) assert.ok(text.includes(words), words);
    assert.equal(await other.locator('.worst img').evaluateAll((images) => images.every((image) => image.naturalWidth === 72)), true);
    assert.equal(await other.locator('button, input, select, script').count(), 0);
    assert.equal(await other.locator('.figures tbody tr').count(), rows + 3, 'rows and the titles of their groups');
    assert.equal(await other.locator('a').first().getAttribute('href'), page.url());
    if (options.screenshots) await other.screenshot({path: join(options.screenshots, 'report.png'), fullPage: true});
    await other.close();
    const markdown = page.waitForEvent('download');
    await page.getByRole('button', {name: 'Markdown', exact: true}).click();
    assert.match(readFileSync(await (await markdown).path(), 'utf8'), /^\| Technique \| Memory: Paper \(B\/px\).*\n\| --- \|.*\n\| \*\*/);
  }],

  // For everyone --------------------------------------------------------------------------------------------------
  ['? lists the keys', async () => {
    await page.keyboard.press('?');
    const dialog = page.getByRole('dialog');
    await dialog.waitFor();
    const text = await dialog.innerText();
    for (const words of ['side by side', 'next frame', 'box in the middle', 'report of what', 'light or dark']) assert.ok(text.toLowerCase().includes(words), words);
    await browser.shot('keys');
    assert.deepEqual(await browser.violations(), []);
    await page.keyboard.press('Escape');
    assert.equal(await dialog.isVisible(), false);
  }],

  ['nothing is measured yet, nothing is there, nothing is found: each says so', async () => {
    await open('#/runs/3');
    await page.getByText('0 of 4 results').waitFor();
    await page.getByText(/is not there yet/).waitFor();
    assert.equal(await page.locator('.results td.quiet').count(), 2);
    await browser.shot('state-empty-run');
    assert.deepEqual(await browser.violations(), []);
    await open('#/runs/4');
    await page.locator('.problem', {hasText: 'the driver lost the device'}).waitFor();
    await browser.shot('state-failed-run');
    assert.deepEqual(await browser.violations(), []);
    await open('#/runs/99');
    await page.locator('.problem').waitFor();
    await browser.shot('state-no-run');
    assert.deepEqual(await browser.violations(), []);
    browser.forgive('404');
  }],

  ['the worst places of a difference are those of the difference', async () => {
    await openRun('#/runs/1?layers=2:image,0:image&mode=difference');
    await press('v');
    await page.getByRole('heading', {name: /^Worst places of .* minus noaa/}).waitFor();
    assert.match(await page.locator('.place').first().getAttribute('aria-label'), /x 40, y 20, 0\.1569/);
  }],

  ['a slow answer shows that it is awaited', async () => {
    const release = service.hold();  // no delay: on a busy machine it may be over before the test looks
    try {
      await open('#/runs');
      await page.locator('.loading .skeleton').first().waitFor();
      await browser.shot('state-loading');
      assert.deepEqual(await browser.violations(), []);
    } finally {
      release();
    }
    await page.locator('tbody tr').first().waitFor();
    assert.equal(await page.locator('.loading').count(), 0);
  }],

  ['a picture that is missing is told where it would be', async () => {
    service.broken.add('error_values');
    await openRun('#/runs/1?frame=7&layers=*:image,*:reference,*:error');
    await press('3');
    await page.locator('.view-message', {hasText: 'status 404'}).waitFor();
    assert.equal(await page.locator('.view-label').count(), 0, 'nothing else is shown under its name');
    await browser.shot('state-no-picture');
    service.broken.clear();
    browser.forgive('404');
    await press('1');
    await page.locator('.view-message').waitFor({state: 'hidden'});
  }],

  ['a lost connection is told, and what is shown stays', async () => {
    await open('#/runs/3');
    await page.getByText('0 of 4 results').waitFor();
    const {port} = service;
    await service.stop();
    await page.locator('.progress.lost').waitFor();
    await page.locator('.lost-banner').waitFor({state: 'visible', timeout: 15_000});
    await browser.shot('state-lost');
    assert.deepEqual(await browser.violations(), []);
    await service.start(port);
    await page.locator('.lost-banner').waitFor({state: 'hidden', timeout: 15_000});
    await page.locator('.progress:not(.lost)').waitFor({timeout: 15_000});
    browser.forgive('ERR_');
  }],

  ['pages have no violation and no sideways scrolling, wide and on a phone, light and dark', async () => {
    for (const [name, size] of [['1280', {width: 1280, height: 800}], ['1920', {width: 1920, height: 1080}], ['phone', {width: 390, height: 844}]]) {
      await page.setViewportSize(size);
      for (const theme of ['light', 'dark']) {
        await page.evaluate((value) => localStorage.setItem('theme', value), theme);
        for (const [title, hash] of [['captures', '#/'], ['runs', '#/runs'], ['nights', '#/nights'], ['run', '#/runs/1?mode=side&box=40,20,16,8&group=technique']]) {
          if (title === 'run') {
            await openRun(hash);
            await page.locator('.box-panel h3').waitFor();
            await page.locator('.lines canvas').waitFor();
            await page.locator('.look summary').click();
            await press('v');
          } else {
            await open(hash);
            await page.locator('h1').waitFor();
          }
          assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${title} is wider than ${name}`);
          assert.deepEqual(await browser.violations(), [], `${title} ${name} ${theme}`);
          await browser.shot(`${title}-${name}-${theme}`);
        }
      }
    }
  }],

  ['nothing went wrong on the pages meanwhile', async () => {
    assert.deepEqual(browser.complaints, []);
  }],
];

await browser.runAndExit(tests, service);
