// The viewer in Chromium against the real service: upload, run, look at the results.
//
//   node viewer_test.mjs [PATH of subpixel] [--fake-worker PATH] [--screenshots DIR]
//
// With --fake-worker (tests/service/fake_worker) no Vulkan device is needed, and failures of workers are looked at too.
// The browser is $SUBPIXEL_CHROMIUM, else `chromium` or `google-chrome` of the search path. Without one the exit code
// is 77, which ctest shows as skipped. Prints "N passed, N failed"; exit code 1 if any failed.
import assert from 'node:assert/strict';
import {readFileSync, writeFileSync} from 'node:fs';
import {join, resolve} from 'node:path';
import {parseArgs} from 'node:util';
import {Browser} from './browser.mjs';
import {policy} from './made_up_service.mjs';
import {Service} from './service.mjs';

const {values: options, positionals} = parseArgs({allowPositionals: true, options: {
  'fake-worker': {type: 'string'},
  screenshots: {type: 'string'},
}});
const browser = new Browser(options.screenshots);
const binary = resolve(positionals[0] ?? join(import.meta.dirname, '../../build/release/subpixel'));
const hostileName = '<img src=x onerror=alert(1)>.spcap';
const notices = ['left out: <b>decals</b>', 'skipped on reading, of kinds that this program does not know: chunks ZXXX'];
const spheres = {title: 'Rows <b>of</b> spheres', frames: 3, width: 320, height: 180, result_ms: 150, notices};
const timeout = 120_000;  // a first frame pays the pipelines' compilation

const service = new Service(binary, options['fake-worker'] ? resolve(options['fake-worker']) : null);
let page;

async function open() {
  await service.start();
  await browser.open();
  page = browser.page;
}

const shot = (name) => browser.shot(name);

const techniqueOf = (name) => page.locator('.technique', {has: page.locator('strong', {hasText: new RegExp(`^${name}$`)})});
const shown = () => page.locator('.view').getAttribute('data-shown');
const viewIsDrawn = (previous) => page.waitForFunction(
  (before) => (document.querySelector('.view')?.dataset.shown ?? null) !== before, previous);
// A pixel of the canvas, by its share of width and height, as the browser shows it.
const canvasPixel = (x, y) => page.locator('.view-canvas').evaluate((canvas, [sx, sy]) =>
  [...canvas.getContext('2d').getImageData(Math.round(canvas.width * sx), Math.round(canvas.height * sy), 1, 1).data], [x, y]);

// The page asks for what it shows, so a count is awaited: one that never comes out is the failure.
const counted = async (locator, expected, why = '') => {
  const ends = Date.now() + timeout;
  while (await locator.count() !== expected && Date.now() < ends) await page.waitForTimeout(20);
  assert.equal(await locator.count(), expected, why || String(locator));
};

const tests = [
  ['an empty service says so', async () => {
    await page.goto(service.url);
    await page.getByText('No captures yet').waitFor();
    const answer = await fetch(service.url);
    assert.equal(answer.headers.get('content-security-policy'), policy, 'made_up_service.mjs has another policy');
  }],

  ['a capture is uploaded by drag and drop, with its thumbnail', async () => {
    const path = service.capture('spheres.spcap', spheres);
    const transfer = await page.evaluateHandle(([base64, name]) => {
      const data = new DataTransfer();
      data.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
      return data;
    }, [readFileSync(path).toString('base64'), hostileName]);
    await page.dispatchEvent('.drop', 'dragover', {dataTransfer: transfer});
    await page.locator('.drop.over').waitFor();
    await page.dispatchEvent('.drop', 'drop', {dataTransfer: transfer});
    await page.locator('.uploads').getByText('stored').waitFor();
    await counted(page.locator('.card'), 1);
    await page.locator('.card img.thumbnail').waitFor({timeout});
    await page.waitForFunction(() => document.querySelector('img.thumbnail').naturalWidth === 320);
    await shot('captures');
  }],

  ['names are text, never markup', async () => {
    await page.locator('.card').getByText(hostileName).waitFor();
    await counted(page.locator('.card img[src="x"]'), 0);
  }],

  ['the same file again is one capture, and a foreign file is refused with the reason', async () => {
    await page.setInputFiles('#file', service.capture('again.spcap', spheres));
    await page.locator('.uploads').getByText('was here already').waitFor();
    const foreign = join(service.folder, 'foreign.spcap');
    writeFileSync(foreign, 'this is no capture');
    await page.setInputFiles('#file', foreign);
    await page.locator('.uploads .problem').waitFor();
    assert.match(await page.locator('.uploads .problem').innerText(), /no valid capture/);
    await counted(page.locator('.card'), 1);
    // The refusal is an answer with status 422, which the browser logs.
    browser.forgive('422');
  }],

  ['the run form is made from the registry', async () => {
    await page.locator('.cover').first().click();
    await page.getByRole('heading', {name: 'New run'}).waitFor();
    const {techniques} = await (await fetch(`${service.url}/api/techniques`)).json();
    await counted(page.locator('.technique'), techniques.length);
    for (const technique of techniques) {
      for (const parameter of technique.parameters.filter(({allowed}) => allowed?.length !== 1)) {
        await techniqueOf(technique.name).getByText(parameter.doc).first().waitFor({state: 'attached'});
      }
    }
    await shot('run-form');
  }],

  ['the notices of a capture are listed, as text', async () => {
    const shownNotices = await page.locator('.notices li').allInnerTexts();
    assert.deepEqual(shownNotices, service.fakeWorker ? notices : []);
    await counted(page.getByRole('heading', {name: 'Notices'}), service.fakeWorker ? 1 : 0);
    await counted(page.locator('.notices b'), 0);
  }],

  ['what the scene needs is told with what it means', async () => {
    const needs = page.locator('.needs > div');
    await counted(needs, service.fakeWorker ? 2 : 1);
    for (const text of await needs.allInnerTexts()) assert.match(text, /^[a-z -]+\n.{20,}\nbecause of \d+ of \d+ (materials|draws|frames)/i);
    if (service.fakeWorker) assert.match(await needs.last().innerText(), /because of 1 of 2 materials: <b>leaf<\/b>$/);
  }],

  ['draws of a frame are a tree; one is highlighted in the picture, and picked by a click in it', async () => {
    const panel = page.locator('.frames-panel');
    await panel.locator('summary').first().click();
    const canvas = page.locator('.frame-canvas');
    await page.locator('.film-picture img').nth(2).waitFor({timeout});  // the service draws one at a time
    const branches = page.locator('.draw-tree > details');
    const {draws, seen, size: [width, height]} = await (await fetch(`${service.url}/api/captures/${/[0-9a-f]{32}/.exec(page.url())[0]}/frame?frame=0&width=640&height=360`)).json();
    await counted(branches, new Set(draws.map(({material}) => material.number)).size);
    // Where the draw that most pixels show is seen, in the middle of the middle one of its long runs.
    const most = draws.reduce((best, draw) => (draw.pixels > best.pixels ? draw : best));
    const runs = [];
    for (let i = 0, at = 0; i < seen.length; at += seen[i + 1], i += 2) if (seen[i] === most.draw && seen[i + 1] >= 8) runs.push(at + (seen[i + 1] >> 1));
    const run = runs[runs.length >> 1];
    const point = {x: run % width, y: Math.floor(run / width)};
    const colour = ({x, y}) => canvas.evaluate((element, [px, py]) => [...element.getContext('2d').getImageData(px, py, 1, 1).data].slice(0, 3), [x, y]);
    const [shownDraw, sky] = [await colour(point), await colour({x: 0, y: 0})];
    await canvas.scrollIntoViewIfNeeded();
    const box = await canvas.boundingBox();
    await page.mouse.click(box.x + (point.x + 0.5) * box.width / width, box.y + (point.y + 0.5) * box.height / height);
    await page.locator('.draw[aria-pressed="true"]', {hasText: `${most.draw} ${most.name}`}).waitFor();
    assert.deepEqual(await colour(point), shownDraw, 'the chosen draw keeps its colours');
    const dimmed = await colour({x: 0, y: 0});
    assert.ok(dimmed.every((value, c) => value < sky[c] / 2), `${sky} is dimmed to ${dimmed}`);
    const details = await page.locator('.draw-details').innerText();
    for (const text of [most.name, most.material.name, `${most.triangles}`, most.textures[0]?.name ?? 'none']) assert.ok(details.includes(text), `${text} in ${details}`);
    await counted(page.locator('.frame-view i, .frame-view b'), 0, 'names are text');
    await shot('draws');
    assert.deepEqual(await browser.violations(), []);
    await page.mouse.click(box.x + 2, box.y + 2);
    await counted(page.locator('.draw[aria-pressed="true"]'), 0, 'a click on the sky chooses none');
    assert.deepEqual(await colour({x: 0, y: 0}), sky);
  }],

  ['frames are a film strip, and one that is clicked is shown', async () => {
    await page.locator('.film-picture img').nth(2).waitFor({timeout});
    await counted(page.locator('.film-frame'), 3);
    await page.getByRole('button', {name: 'Frame 2', exact: true}).click();
    await page.locator('.frame-canvas[aria-label="Frame 2"]').waitFor({timeout});
    assert.equal(await page.locator('.film-frame[aria-pressed="true"]').innerText(), '2');
    await shot('film-strip');
  }],

  ["a capture's frames and draws are walked by keys, and reported", async () => {
    await page.locator('.frame-canvas').focus();
    await page.keyboard.press('[');
    await page.locator('.frame-canvas[aria-label="Frame 1"]').waitFor({timeout});
    await page.keyboard.press(']');
    await page.locator('.frame-canvas[aria-label="Frame 2"]').waitFor({timeout});
    await page.keyboard.press(']');  // the last one
    await page.keyboard.press('j');
    await page.locator('.frame-canvas[aria-label^="Frame 2, highlighted: 0 "]').waitFor();
    await page.keyboard.press('k');  // round its end, as j goes
    const {draws} = await (await fetch(`${service.url}/api/captures/${/[0-9a-f]{32}/.exec(page.url())[0]}/frame?frame=2&width=640&height=360`)).json();
    const seen = draws.filter(({pixels}) => pixels > 0);
    await page.locator(`.frame-canvas[aria-label^="Frame 2, highlighted: ${seen.at(-1).draw} "]`).waitFor();
    const download = page.waitForEvent('download');
    await page.keyboard.press('r');
    const html = readFileSync(await (await download).path(), 'utf8');
    for (const words of ['What the scene needs', 'Frame 2: ', `${seen.at(-1).triangles} `, 'src="data:image/png;base64,']) assert.ok(html.includes(words), words);
    assert.ok(!/<script|<button|<img src=x/.test(html), 'names are text, and nothing can be pressed');
    await page.keyboard.press('0');
    await counted(page.locator('.draw[aria-pressed="true"]'), 0);
    await page.keyboard.press('?');
    assert.match(await page.getByRole('dialog').innerText(), /This capture.*next draw.*report of what is on the screen/s);
    await page.keyboard.press('Escape');
  }],

  ['the frame and what is chosen in it are in the address, which restores them', async () => {
    const parameters = () => Object.fromEntries(new URLSearchParams(new URL(page.url()).hash.split('?')[1] ?? ''));
    const expectParameters = async (expected) => {
      await page.waitForFunction((text) => new URLSearchParams(location.hash.split('?')[1] ?? '').toString() === text, String(new URLSearchParams(expected))).catch(() => {});
      assert.deepEqual(parameters(), expected);
    };
    const chosen = () => page.locator('.draw[aria-pressed="true"]').evaluateAll((buttons) => buttons.map((button) => button.dataset.draws));
    const reopen = async (address) => {
      await page.goto('about:blank');
      await page.goto(address);
      await page.locator('.draw-details').waitFor({timeout});
    };
    await expectParameters({frame: '2'});
    const last = page.locator('.draw-tree > details').last();
    if (await last.getAttribute('open') === null) await last.locator('summary').click();
    const draw = last.locator('li .draw').first();
    const number = await draw.getAttribute('data-draws');
    await draw.click();
    await expectParameters({frame: '2', draw: number});
    const [colours, details] = [await page.locator('.frame-canvas').evaluate((canvas) => canvas.toDataURL()), await page.locator('.draw-details').innerText()];

    const address = page.url();
    await reopen(address);
    assert.deepEqual(await chosen(), [number]);
    assert.equal(await page.locator('.film-frame[aria-pressed="true"]').innerText(), '2');
    assert.equal(await page.getByLabel('Frame', {exact: true}).inputValue(), '2');
    assert.equal(await page.locator('.draw-details').innerText(), details);
    assert.equal(await page.locator('.frame-canvas').evaluate((canvas) => canvas.toDataURL()), colours);
    assert.equal(page.url(), address);

    const all = page.getByRole('button', {name: 'all of it'});
    if (service.fakeWorker) {
      const group = page.locator('.draw-tree > details', {has: all}).first();
      if (await group.getAttribute('open') === null) await group.locator('summary').click();
      await all.first().click();
      const material = await group.getAttribute('data-material');
      const draws = await all.first().getAttribute('data-draws');
      await expectParameters({frame: '2', material});
      await reopen(page.url());
      assert.deepEqual(await chosen(), [draws]);
      await all.first().waitFor();
    }

    await reopen(address.replace(/frame=.*/, 'frame=9&draw=99'));
    assert.deepEqual(await chosen(), [], 'what the capture does not have is not chosen');
    await expectParameters({frame: '0'});
    await page.locator('.frames-panel > summary').click();
    await expectParameters({});
  }],

  ['draws have no violation and no sideways scrolling, wide and on a phone, light and dark', async () => {
    const size = page.viewportSize();
    const address = page.url();
    for (const theme of ['dark', 'light']) {
      for (const [name, wanted] of [['phone', {width: 375, height: 812}], ['wide', size]]) {
        await page.evaluate((value) => localStorage.setItem('theme', value), theme);
        await page.setViewportSize(wanted);
        await page.goto('about:blank');
        await page.goto(`${address}?frame=1&draw=0`);
        await page.locator('.draw[aria-pressed="true"]').waitFor({timeout});
        assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `wider than ${name}`);
        assert.deepEqual(await browser.violations(), [], `${name} ${theme}`);
        await shot(`draws-${name}-${theme}`);
      }
    }
    await page.evaluate(() => localStorage.removeItem('theme'));
    await page.goto('about:blank');
    await page.goto(address);
    await page.getByRole('heading', {name: 'New run'}).waitFor();
  }],

  ['a wrong number is named by the form before it is sent', async () => {
    await page.getByLabel('Last frame').fill('99');
    await page.getByRole('button', {name: 'Start run'}).click();
    assert.equal(await page.getByLabel('Last frame').evaluate((input) => input.validity.rangeOverflow), true);
    await page.getByLabel('Last frame').fill('2');
  }],

  ["the form's ranges are the service's", async () => {
    const {limits} = await (await fetch(`${service.url}/api/limits`)).json();
    for (const [label, name] of [['Repeats', 'repeat'], ['Point lights', 'point_lights'], ['Width in pixels', 'width']]) {
      const limit = limits.find((entry) => entry.name === name);
      const input = page.getByLabel(label);
      assert.deepEqual([await input.getAttribute('min'), await input.getAttribute('max')], [`${limit.low}`, `${limit.high}`], label);
    }
  }],

  ['a run starts and its progress is live', async () => {
    await page.getByLabel('Samples per pixel').selectOption('4');
    await page.getByLabel('Reference samples').selectOption('64');
    await page.getByLabel('Every light at every point').check();
    const msaa = techniqueOf('msaa');
    await msaa.getByRole('button', {name: 'another variant'}).click();
    await msaa.locator('.variant').nth(1).getByLabel('samples').selectOption('8');
    await page.getByRole('button', {name: 'Start run'}).click();
    await page.waitForURL(/#\/runs\/\d+$/);
    const {request} = await (await fetch(`${service.url}/api/runs/${/\d+$/.exec(page.url())[0]}`)).json();
    assert.equal(request.every_light, true);
    await page.locator('.results tbody tr').first().waitFor();
    await page.waitForFunction(() => /[1-8] of 9 results/.test(document.querySelector('.progress')?.innerText ?? ''), null, {timeout});
    await shot('run-live');
    await page.locator('.pill.done, .pill.failed').waitFor({timeout: 5 * timeout});
    assert.match(await page.locator('.progress').innerText(), /done.*9 of 9 results/s);
  }],

  ['the table has memory, lighting, time with its ratio to msaa, and error', async () => {
    const rows = page.locator('.results tbody tr');
    await counted(rows, 3);
    const baseline = await rows.nth(1).innerText();
    assert.match(baseline, /msaa samples=4/);
    assert.match(baseline, /1\.00×/);
    for (let row = 0; row < 3; ++row) {
      await counted(rows.nth(row).locator('td'), 11);
      assert.doesNotMatch(await rows.nth(row).innerText(), /NaN|undefined|not measured/);
    }
    await page.getByText('Time by pass').click();
    await page.locator('.pass-bar span').nth(2).waitFor({state: 'attached'});
  }],

  ['cost against error is plotted with its front, and can be taken away', async () => {
    await page.locator('.plot[data-drawn="total mse"] svg .point').nth(2).waitFor();
    await counted(page.locator('.plot svg .point'), 3);
    assert.match(await page.locator('.plot').innerText(), /msaa samples=8/);
    await page.getByLabel('Measure across').selectOption('fitted');
    await page.locator('.plot[data-drawn="fitted mse"]').waitFor();
    await page.locator('.plot svg .front').waitFor({state: 'attached'});  // of memory: times of a busy machine may have one winner
    for (const [role, link, file] of [['button', 'SVG', /fitted-mse\.svg$/], ['link', 'Points as CSV', /points\.csv$/], ['link', 'Points as Markdown', /points\.md$/]]) {
      const download = page.waitForEvent('download');
      await page.getByRole(role, {name: link, exact: true}).first().click();
      assert.match((await download).suggestedFilename(), file);
    }
    await shot('plot');
  }],

  ['the advisor names the cheapest settings with runner-up and reason', async () => {
    await page.getByLabel('FLIP, mean').fill('');
    await page.getByLabel('MSE', {exact: true}).fill('1');
    await page.getByRole('button', {name: 'Advise'}).click();
    await page.getByText('3 of 3 measured settings are within the budget').waitFor();
    await counted(page.locator('.advice > li'), 3);
    assert.match(await page.locator('.advice > li').first().innerText(), /Least memory.*noaa.*Then.*msaa/is);
    await page.locator('.advice summary').first().click();
    assert.match(await page.locator('.advice > li').first().innerText(), /worst frame: MSE/);
  }],

  ['the wipe shows the image on one side and the reference on the other', async () => {
    await page.getByRole('button', {name: 'Image ⇔ reference'}).click();
    await page.locator('.view-label.left').getByText('msaa').waitFor();
    const wipe = page.getByLabel('Position of the dividing line');
    await page.locator('.view-canvas').scrollIntoViewIfNeeded();
    const box = await page.locator('.view-canvas').boundingBox();
    const before = await wipe.inputValue();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.25, box.y + box.height / 2, {steps: 4});
    await page.mouse.up();
    assert.equal(before, '500');
    assert.ok(Math.abs(Number(await wipe.inputValue()) - 250) < 5, 'the line follows the pointer');
    await page.mouse.move(box.x + box.width * 0.5, box.y + box.height * 0.5);
    await page.locator('.view[data-values]').waitFor();
    assert.match(await page.locator('.readout').innerText(), /x \d+, y \d+.*msaa.*reference.*error.*executions/s);
    await shot('wipe');
  }],

  ['zoom shows pixels as squares, and keys work', async () => {
    await page.locator('.view-canvas').focus();
    await page.keyboard.press('z');
    while (await page.locator('.scale').innerText() !== '16.0×') await page.keyboard.press('z');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press(',');
    assert.ok(Number(await page.getByLabel('Position of the dividing line').inputValue()) < 250);
    await shot('zoom');
    await page.keyboard.press('0');
  }],

  ["a click tells the pixel's story beside those of msaa and the reference, as text", async () => {
    await page.locator('.view-canvas').scrollIntoViewIfNeeded();
    const box = await page.locator('.view-canvas').boundingBox();
    await page.mouse.click(box.x + box.width * 0.4, box.y + box.height * 0.5);
    await page.locator('.pixel-story .story').first().waitFor({timeout});
    assert.match(await page.locator('.pixel-story').innerText(), /Pixel \d+, \d+ of frame 0.*lighting executions.*covers.*Resolve: the mean of \d+ samples.*reference/is);
    await page.locator('.pixel-story .pattern circle').first().waitFor({state: 'attached'});
    await counted(page.locator('.pixel-story b'), 0, 'a material\'s name is text');
    if (service.fakeWorker) {
      // What an aggregate has instead of an albedo, and a filter's steps with the luma it looked at.
      assert.match(await page.locator('.pixel-story .story', {hasText: 'agaa'}).innerText(), /Kept\s+aggregate\s+covers\s+weight\s+reversed depth\s+normal\s+diffuse\s+reflectance.*0x3\s+2\s+0\.25/is);
      const filtered = page.locator('.pixel-story .story', {hasText: 'fxaa'});
      assert.match(await filtered.innerText(), /The filter.*luma\s+0\.5000 here\s+blend\s+0\.7500 of the pixel's <b>value<\/b>/is);
      assert.deepEqual(await filtered.locator('.luma span').allInnerTexts(), ['0.10', '0.20', '0.30', '0.40', '0.50', '0.60', '0.70', '0.80', '0.90']);
    }
    await shot('pixel-story');
    for (const theme of ['dark', 'light']) {
      await page.evaluate((value) => (document.documentElement.dataset.theme = value), theme);
      assert.deepEqual(await browser.violations(), [], `a story, ${theme}`);
    }
    await page.evaluate(() => delete document.documentElement.dataset.theme);
    await page.getByRole('button', {name: 'Close'}).click();
    assert.equal(await page.locator('.pixel-story').isVisible(), false);
  }],

  ['the frame slider changes the images and the figures', async () => {
    const before = await shown();
    const figures = await page.locator('.results tbody').innerText();
    await page.locator('.frame input').focus();
    await page.keyboard.press('ArrowRight');
    await viewIsDrawn(before);
    assert.equal(await page.locator('.frame-number').innerText(), '1');
    assert.notEqual(await page.locator('.results tbody').innerText(), figures);
  }],

  ['FLIP of the page is FLIP of the service', async () => {
    await page.getByRole('button', {name: 'FLIP map'}).click();
    const result = (await (await fetch(`${service.url}/api/runs/${/runs\/(\d+)/.exec(page.url())[1]}/results.json`)).json()).results.find(({frame, technique, samples}) => frame === 1 && technique === 'msaa' && samples === 8);
    const mean = await page.evaluate(async ({images}) => {
      const {ask} = await import('/pixels.js');
      const layer = (role) => ({url: `/api/blobs/${images[role]}`, kind: 'display'});
      return ask('meanDifference', {a: layer('image'), b: layer('reference'), measure: 'flip'});
    }, result);
    // The worker measures before rounding to the 8 bits that the page has; the fake one has 8 bits as well.
    assert.ok(Math.abs(mean - result.error.flip_mean) < (service.fakeWorker ? 2e-3 : 0.06) * result.error.flip_mean + 1e-5, `${mean} ${result.error.flip_mean}`);
    await page.getByRole('button', {name: 'Image ⇔ reference'}).click();
  }],

  ['error and shading maps have a legend with numbers and unit', async () => {
    let before = await shown();
    await page.getByRole('button', {name: 'Error map'}).click();
    await viewIsDrawn(before);
    assert.match(await page.locator('.legend').first().innerText(), /0.*0\.25/s);
    const {palettes} = await (await fetch(`${service.url}/api/palettes`)).json();
    const bar = await page.locator('.legend-bar').first().evaluate((element) => element.style.background);
    const colours = palettes.magma.map((colour) => `rgb(${[1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16)).join(', ')})`);
    assert.equal(bar, `linear-gradient(to right, ${colours.join(', ')})`);
    assert.equal((await canvasPixel(0.5, 0.5))[3], 255);
    await shot('error-map');
    before = await shown();
    await page.getByRole('button', {name: 'Shading map'}).click();
    await viewIsDrawn(before);
    assert.match(await page.locator('.legend').first().innerText(), /executions/);
    await shot('shading-map');
  }],

  ['results download as CSV and JSON', async () => {
    for (const kind of ['CSV', 'JSON']) {
      const download = page.waitForEvent('download');
      await page.getByRole('link', {name: kind, exact: true}).click();
      assert.match((await download).suggestedFilename(), new RegExp(`results\\.${kind.toLowerCase()}$`));
    }
  }],

  ['runs are listed, also in the dark', async () => {
    await page.getByRole('button', {name: 'light and dark'}).click();
    await page.getByRole('link', {name: 'Runs', exact: true}).first().click();
    await page.getByRole('heading', {name: 'Runs', exact: true, level: 1}).waitFor();  // the run's page has such a pill too
    await page.locator('.pill.done').waitFor();
    await counted(page.locator('tbody tr'), 1);
    await shot('runs-dark');
    await page.locator('tbody a').first().click();
    await page.locator('.view[data-shown]').waitFor();
    await shot('run-dark');
  }],

  ['a failed run says why', async () => {
    if (!service.fakeWorker) return;
    await page.goto(`${service.url}/#/`);
    await page.setInputFiles('#file', service.capture('crash.spcap', {title: 'Crashes', frames: 2, fail_at: 2, how: 'exit'}));
    await page.locator('.uploads').getByText('stored').waitFor();
    await page.locator('.card').getByText('Crashes').click();
    await page.getByRole('button', {name: 'Start run'}).click();
    await page.locator('.pill.failed').waitFor({timeout});
    assert.match(await page.locator('.progress .problem').innerText(), /exit code 4.*lost the device/);
    await shot('run-failed');
  }],

  ['a sweep in the form\'s text makes one row for each of its points', async () => {
    await page.goto(`${service.url}/#/`);
    await page.locator('.cover').last().click();
    await page.getByRole('heading', {name: 'New run'}).waitFor();
    await techniqueOf('msaa').locator('.technique-name').click();
    await page.getByLabel('Further ones').fill('msaa:samples=4|8');
    await page.getByLabel('Last frame').fill('0');
    await page.getByLabel('Reference samples').selectOption('0');
    await page.getByRole('button', {name: 'Start run'}).click();
    await page.locator('.results tbody tr').nth(2).waitFor();
    await counted(page.locator('.results tbody tr'), 3);
    await page.locator('.pill.done').waitFor({timeout});
    // Without a reference there is no error to plot.
    await page.locator('.plot[data-drawn="total fitted"] svg .point').nth(2).waitFor();
  }],

  ['a night is a grid, and a failed cell opens baseline, tonight and difference', async () => {
    // The second night replays another scene under the same name, as if a change of code had changed it; the made-up worker measures only sizes.
    const config = (scene) => ({name: 'browser', techniques: 'noaa,msaa:samples=4', size: [service.fakeWorker && scene !== 'cube' ? 65 : 64, 36], reference_samples: 16, repeat: 1,
      captures: [service.fakeWorker ? {path: service.capture('night.spcap', {frames: 1, title: scene, width: scene === 'cube' ? 64 : 65}), name: 'shape'} : {scene, name: 'shape'}]});
    assert.equal(service.nightly(config('cube')), 0);
    await page.getByRole('link', {name: 'Nights'}).click();
    await page.locator('.nights tbody tr').waitFor();
    await page.locator('.nights tbody a').first().click();
    await page.locator('.cell.new').first().waitFor();
    await counted(page.locator('.cell'), 2);
    page.once('dialog', (dialog) => dialog.accept());
    await page.getByRole('button', {name: 'Approve as browser'}).click();
    await page.locator('.label', {hasText: 'baseline browser'}).waitFor();

    assert.equal(service.nightly(config('cube')), 0);
    assert.equal(service.nightly(config('spheres')), 1);
    await page.getByRole('link', {name: 'Nights'}).first().click();
    await page.locator('.nights tbody tr').nth(2).waitFor();
    assert.match(await page.locator('.nights').innerText(), /failed[\s\S]*2 failed[\s\S]*passed[\s\S]*2 passed/);
    await page.locator('.nights tbody a').first().click();
    await page.locator('.cell.failed').first().click();
    await page.locator('.pictures img').first().waitFor();
    assert.match(await page.locator('.gates').innerText(), /capture\s+failed/);
    if (!service.fakeWorker) {
      assert.deepEqual(await page.locator('.pictures img').evaluateAll((images) => images.map((image) => image.alt)), ['baseline', 'tonight', 'difference']);
      await page.waitForFunction(() => [...document.querySelectorAll('.pictures img')].every((image) => image.naturalWidth === 64));
      assert.equal(new Set(await page.locator('.pictures img').evaluateAll((images) => images.map((image) => image.src))).size, 3);
    }
    await page.locator('.view[data-shown]').waitFor();
    await shot('night');
  }],

  ['trends show every number of a cell over the nights, and where one moved', async () => {
    await page.getByRole('link', {name: 'Trend', exact: true}).click();
    await page.getByRole('heading', {name: 'Trends of browser'}).waitFor();
    await page.locator('.trend-plot canvas').first().waitFor();
    const words = await page.locator('.trend-plot').evaluateAll((plots) => plots.map((plot) => plot.getAttribute('aria-label')));
    assert.ok(words.some((text) => /^lighting executions over 3 nights/.test(text)), words.join('; '));
    assert.match(await page.locator('.changes').innerText(), /between night 2 and night 3/);
    const choice = page.getByLabel('Cell');
    assert.equal(await choice.evaluate((select) => select.selectedIndex), 0);
    await page.keyboard.press('n');
    await page.waitForFunction(() => /technique=msaa/.test(location.hash));
    assert.equal(await choice.evaluate((select) => select.selectedIndex), 1);
    await page.keyboard.press('p');
    await page.waitForFunction(() => /technique=noaa/.test(location.hash));
    const csv = await (await page.request.get(new URL(await page.getByRole('link', {name: 'CSV', exact: true}).getAttribute('href'), service.url).href)).text();
    assert.match(csv, /^night,started_utc,commit,/);
    assert.deepEqual(await browser.violations(), []);
    await shot('trends');
  }],

  ['nothing went wrong on the pages meanwhile', async () => {
    assert.deepEqual(browser.complaints, []);
  }],
];

await browser.runAndExit([['the service starts', open], ...tests], service);
