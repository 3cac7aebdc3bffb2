// What the tasks of the page's thread take: by the clock, and of processor time, which other programs of the machine don't add to.

export class TaskTimes {
  #session;
  #events = [];

  async start(page) {
    this.#session ??= await page.context().newCDPSession(page);
    this.#session.on('Tracing.dataCollected', ({value}) => this.#events.push(...value));
    await this.#begin();
  }

  async #begin() {
    this.#events.length = 0;
    await this.#session.send('Tracing.start', {traceConfig: {includedCategories: ['toplevel', '__metadata']}, transferMode: 'ReportEvents'});
  }

  /** Tasks since start() or the last call: [{wall, cpu}] in ms. */
  async take() {
    const complete = new Promise((resolve) => this.#session.once('Tracing.tracingComplete', resolve));
    await this.#session.send('Tracing.end');
    await complete;
    const main = new Set(this.#events.filter(({name, args}) => name === 'thread_name' && args.name === 'CrRendererMain').map(({pid, tid}) => `${pid}:${tid}`));
    const tasks = this.#events.filter(({name, ph, tdur, pid, tid}) => name === 'ThreadControllerImpl::RunTask' && ph === 'X' && tdur !== undefined && main.has(`${pid}:${tid}`))
      .map(({dur, tdur}) => ({wall: dur / 1000, cpu: tdur / 1000}));
    await this.#begin();
    return tasks;
  }
}
