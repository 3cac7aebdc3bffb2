// How soon the viewer can be used, and a run of 300 frames and 12 techniques scrolled and scrubbed, with made-up results.
//
//   node speed_test.mjs
//
// Bounds are those of the project: first page below 150 KB and 1 s, a swap of what is cached below 100 ms, no task of the page's
// thread above 50 ms, memory bounded. Tasks are judged by their processor time, so that what else runs on the machine is not
// counted; the clock's time is printed beside it.
import assert from 'node:assert/strict';
import {Browser} from './browser.mjs';
import {MadeUpService} from './made_up_service.mjs';
import {TaskTimes} from './task_times.mjs';

const browser = new Browser();
const [frames, rows] = [300, 12];
const service = new MadeUpService({1: {width: 320, height: 180, frames, rows}});
let page;

const times = new TaskTimes();
const longest = 50;  // ms

async function noLongTask(when) {
  const tasks = (await times.take()).sort((p, q) => q.cpu - p.cpu);
  const text = ({cpu, wall}) => `${Math.round(cpu)} (${Math.round(wall)})`;
  console.log(`${when}: ${tasks.length} tasks; longest, in ms of processor (clock): ${tasks.slice(0, 4).map(text).join(', ')}`);
  assert.ok(tasks.length > 0);
  assert.deepEqual(tasks.filter(({cpu}) => cpu > longest).map(text), []);
}

const tests = [
  ['the first page is small and soon usable', async () => {
    await service.start();
    await browser.open();
    page = browser.page;
    const started = performance.now();
    await page.goto(service.url);
    await page.getByText('No captures yet').waitFor();
    const usable = performance.now() - started;
    const bytes = await page.evaluate(() => performance.getEntriesByType('resource').concat(performance.getEntriesByType('navigation')).reduce((sum, {transferSize}) => sum + transferSize, 0));
    console.log(`first page: ${bytes} bytes, usable after ${Math.round(usable)} ms`);
    assert.ok(bytes > 10_000 && bytes < 150 * 1024, `${bytes} bytes`);
    assert.ok(usable < 1000, `${usable} ms`);
    await times.start(page);
  }],

  ['a large run opens without a long task', async () => {
    await page.goto(`${service.url}/#/runs/1`);
    await page.locator('.view[data-shown]').waitFor();
    await page.waitForFunction((expected) => document.querySelector('.progress')?.innerText.includes(expected), `${frames * rows} of ${frames * rows} results`);
    await page.locator('.lines canvas').waitFor();
    await page.waitForTimeout(1500);
    await noLongTask('opening');
  }],

  ['it scrolls without a long task', async () => {
    await page.mouse.move(700, 500);
    const height = await page.evaluate(() => document.documentElement.scrollHeight);
    for (let at = 0; at < height; at += 300) {
      await page.mouse.wheel(0, 300);
      await page.waitForTimeout(30);
    }
    await noLongTask('scrolling');
  }],

  ['frames are scrubbed: swaps of what is cached within 100 ms', async () => {
    const swap = (frame) => page.evaluate(async (wanted) => {
      const slider = document.querySelector('.frame input');
      const view = document.querySelector('.view');
      const before = view.dataset.shown;
      const start = performance.now();
      slider.value = wanted;
      slider.dispatchEvent(new Event('input'));
      while (view.dataset.shown === before) await new Promise(requestAnimationFrame);
      return performance.now() - start;
    }, frame);
    for (let frame = 1; frame <= 12; ++frame) await swap(frame);
    await times.take();
    const swaps = [];
    for (let turn = 0; turn < 3; ++turn) {
      for (let frame = 11; frame >= 1; --frame) swaps.push(await swap(frame));
      for (let frame = 2; frame <= 12; ++frame) swaps.push(await swap(frame));
    }
    const worst = Math.max(...swaps);
    console.log(`swaps of cached frames: worst ${Math.round(worst)} ms, mean ${Math.round(swaps.reduce((a, b) => a + b) / swaps.length)} ms`);
    assert.ok(worst < 100, `${worst} ms`);
    await noLongTask('scrubbing');
  }],

  ['memory stays bounded over all frames', async () => {
    for (let frame = 0; frame < frames; frame += 1) {
      await page.evaluate(async (wanted) => {
        const slider = document.querySelector('.frame input');
        slider.value = wanted;
        slider.dispatchEvent(new Event('input'));
        await new Promise(requestAnimationFrame);
      }, frame);
    }
    await page.waitForFunction(() => document.querySelector('.view').getAttribute('aria-busy') === 'false');
    const {held, heap} = await page.evaluate(async () => ({held: (await import('/pixels.js')).heldBytes(), heap: performance.memory.usedJSHeapSize}));
    console.log(`after all frames: ${(held / 2 ** 20).toFixed(0)} MiB of coloured pictures, ${(heap / 2 ** 20).toFixed(0)} MiB of heap`);
    assert.ok(held <= 161 * 2 ** 20, `${held} bytes`);
    assert.ok(heap <= 300 * 2 ** 20, `${heap} bytes`);
    await noLongTask('all frames');
    assert.deepEqual(browser.complaints, []);
  }],
];

await browser.runAndExit(tests, service);
