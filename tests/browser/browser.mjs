// Chromium for the tests, what its pages must not cause, and the loop that runs tests one after the other.
import {execFileSync} from 'node:child_process';
import {mkdirSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {chromium} from 'playwright-core';

function installed(name) {
  try {
    return execFileSync('which', [name], {encoding: 'utf8'}).trim();
  } catch {
    return '';  // `which` fails when there is none
  }
}

export class Browser {
  complaints = [];  // script errors, refused resources, dialogs
  #profile = mkdtempSync(join(tmpdir(), 'subpixel-profile-'));
  #screenshots;

  /** Leaves with exit code 77, which ctest shows as skipped, where there is no browser. */
  constructor(screenshots) {
    this.#screenshots = screenshots;
    this.executablePath = process.env.SUBPIXEL_CHROMIUM || ['chromium', 'google-chrome'].map(installed).find(Boolean);
    if (!this.executablePath) {
      console.log('skipped: no browser; install chromium, or name one in SUBPIXEL_CHROMIUM');
      process.exit(77);
    }
  }

  async open(viewport = {width: 1360, height: 900}) {
    this.context = await chromium.launchPersistentContext(this.#profile, {
      executablePath: this.executablePath, headless: true, viewport, acceptDownloads: true, colorScheme: 'light',
      args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync'],
    });
    this.page = this.context.pages()[0] ?? await this.context.newPage();
    this.page.setDefaultTimeout(Number(process.env.SUBPIXEL_BROWSER_TIMEOUT_MS) || 30_000);
    this.page.on('pageerror', (error) => this.complaints.push(`script error: ${error.message}`));
    this.page.on('console', (message) => message.type() === 'error' && this.complaints.push(`console: ${message.text()} ${message.location().url}`));
  }

  async close() {
    await this.context?.close();
    rmSync(this.#profile, {recursive: true, force: true});
  }

  /** What was asked for and refused is logged by the browser: tests that ask for it take its mention away. */
  forgive(words) {
    this.complaints.splice(0, this.complaints.length, ...this.complaints.filter((text) => !text.includes(words)));
  }

  async shot(name) {
    if (!this.#screenshots) return;
    const before = await this.page.evaluate(() => [scrollY, scrollTo(0, 0)][0]);  // the header sticks to where the page is scrolled
    mkdirSync(this.#screenshots, {recursive: true});
    await this.page.screenshot({path: join(this.#screenshots, `${name}.png`), fullPage: true});
    await this.page.evaluate((top) => scrollTo(0, top), before);
  }

  /** What axe-core finds wrong with the page, as lines; by evaluation, which the page's content security policy is not asked about. */
  async violations() {
    const source = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
    if (!await this.page.evaluate(() => 'axe' in window)) await this.page.evaluate(source);
    return this.page.evaluate(async () => (await window.axe.run(document)).violations.map(({id, help, nodes}) =>
      `${id}: ${help}: ${nodes.map(({target, failureSummary}) => `${target} ${failureSummary}`).slice(0, 3).join(' | ')}`));
  }

  /** Runs the tests, ends browser and service whatever comes of them, and the process with the exit code. */
  async runAndExit(tests, service) {
    let code = 1;
    try {
      code = await this.run(tests);
    } finally {
      await this.close();
      await service.stop().catch(() => {});
    }
    process.exit(code);
  }

  /**
   * Runs [name, test] in order. Each goes on where the one before left the page, so the first failure ends it, unless
   * SUBPIXEL_KEEP_GOING is set. Returns the exit code.
   */
  async run(tests) {
    let passed = 0;
    for (const [name, test] of tests) {
      try {
        await test();
        ++passed;
        console.log(`ok      ${name}`);
      } catch (error) {
        console.log(`FAILED  ${name}\n${error.stack}\n${this.complaints.join('\n')}`);
        await this.shot(`failed-${tests.findIndex((entry) => entry[0] === name)}`).catch(() => {});
        if (!process.env.SUBPIXEL_KEEP_GOING) break;
      }
    }
    console.log(`${passed} passed, ${tests.length - passed} failed`);
    return passed < tests.length ? 1 : 0;
  }
}
