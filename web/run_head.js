// How far a run is, what can be done with it, and what was run.
import {post, remove} from './api.js';
import {announce, h, replace} from './dom.js';
import {bytes, count, duration, fixed, when} from './format.js';
import {frameRange, runSize, statusPill} from './runs_page.js';

/** What was run, as [name, text]. */
export function factsOf({head, request, started_utc: started}) {
  return [
    ['started', when(started)],
    ['frames', frameRange(request.frames)],
    ['size', runSize(request, head?.width, head?.height)],
    ['reference', request.reference_samples > 0 ? `${request.reference_samples} samples` : 'none'],
    ['repeats', request.repeat],
    head && ['driver', `${head.driver} ${head.driver_version}`], head && ['device', head.device], head && ['CPU', head.cpu_model],
    head && ['triangles, first frame', count(head.triangles_first_frame)], head && ['point lights', `${head.point_lights}${head.every_light ? ', every one evaluated' : ''}`],
    head?.memory_mib > 0 && ['memory', `at most ${head.memory_mib} MiB${head.bands > 0 ? `: frames in up to ${count(head.bands)} bands, ${bytes(head.peak_bytes)} held` : ''}`],
    head && ['scene needs', head.features.join(', ') || 'nothing special'],
    head?.wall_s > 0 && ['wall time', `${duration(head.wall_s)}, ${fixed((100 * head.outside_gpu_s) / head.wall_s, 0)} % outside of passes`],
    head && ['build', head.build],
  ].filter(Boolean);
}

function remaining({started_utc: started, stored_results: stored, expected_results: expected}) {
  if (!started || stored < 2) return null;
  const seconds = ((Date.now() - Date.parse(started)) / 1000 / stored) * (expected - stored);
  return h('span.quiet', {}, `about ${duration(seconds)} left`);
}

async function act(action) {
  try {
    await action();
  } catch (error) {
    announce(error.message);
  }
}

export class RunHead {
  progress = h('div.progress', {});
  facts = h('dl.facts.wide', {});

  draw(run) {
    this.drawProgress(run);
    replace(this.facts, factsOf(run).map(([name, value]) => h('div', {}, h('dt', {}, name), h('dd', {}, value))));
  }

  drawProgress(run) {
    const {id, status, reason, stored_results: stored, expected_results: expected, progress} = run;
    const active = status === 'queued' || status === 'running';
    this.progress.classList.remove('lost');
    replace(this.progress, statusPill(status),
      active && h('progress', {max: expected, value: stored, 'aria-label': 'Results'}),
      h('span', {}, `${stored} of ${expected} results`),
      active && progress && h('span.quiet', {}, `${progress.stage}: ${progress.detail}`),
      active && remaining(run),
      h('span.spacer', {}),
      active && h('button', {type: 'button', onclick: () => act(() => post(`/api/runs/${id}/cancel`))}, 'Cancel run'),
      !active && h('button.danger', {type: 'button', onclick: () => act(async () => {
        if (!confirm(`Delete run ${id} and its images?`)) return;
        await remove(`/api/runs/${id}`);
        location.hash = '#/runs';
      })}, 'Delete run'),
      reason && h('p.problem', {role: 'alert'}, reason));
  }

  lost() {
    this.progress.classList.add('lost');
    announce('Connection lost, trying again');
  }
}
