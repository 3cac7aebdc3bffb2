// Starts `subpixel serve` on a free port with a data folder of its own, and makes captures for it.
import {execFileSync, spawn, spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

export class Service {
  /** @param binary path of `subpixel`; @param fakeWorker path of a stand-in for its worker, or null for the real one */
  constructor(binary, fakeWorker) {
    this.binary = binary;
    this.fakeWorker = fakeWorker;
    this.folder = mkdtempSync(join(tmpdir(), 'subpixel-browser-'));
  }

  async start() {
    const worker = this.fakeWorker ? ['--worker-program', this.fakeWorker] : [];
    this.process = spawn(this.binary, ['serve', '--data', join(this.folder, 'data'), '--listen', '127.0.0.1:0', ...worker],
      {stdio: ['ignore', 'pipe', 'inherit']});
    this.url = await new Promise((resolve, reject) => {
      let output = '';
      this.process.stdout.on('data', (bytes) => {
        output += bytes;
        const match = /http:\/\/\S+/.exec(output);
        if (match) resolve(match[0]);
      });
      this.process.on('exit', (code) => reject(new Error(`the service ended with code ${code}`)));
    });
  }

  /** A capture file; `behaviour` only means something to the fake worker (tests/service/fake_worker). */
  capture(name, behaviour) {
    const path = join(this.folder, name);
    if (this.fakeWorker) {
      writeFileSync(path, `FAKE ${JSON.stringify(behaviour)}\n`);
    } else {
      execFileSync(this.binary, ['generate', 'spheres', path, '--frames', String(behaviour.frames), '--size', '160x90', '--seed', '7']);
    }
    return path;
  }

  /** Runs a night beside the service; `config` is its configuration. Returns the exit code. */
  nightly(config) {
    const path = join(this.folder, 'nightly.json');
    writeFileSync(path, JSON.stringify(config));
    const worker = this.fakeWorker ? ['--worker-program', this.fakeWorker] : [];
    return spawnSync(this.binary, ['nightly', '--config', path, '--data', join(this.folder, 'data'), ...worker],
      {stdio: ['ignore', 'ignore', 'ignore']}).status;
  }

  async stop() {
    if (this.process && this.process.exitCode === null) {
      const ended = new Promise((resolve) => this.process.on('exit', resolve));
      this.process.kill('SIGTERM');
      await ended;
    }
    rmSync(this.folder, {recursive: true, force: true});
  }
}
