#!/usr/bin/env python3
"""Can a night's times be trusted? Runs short nights that nothing has changed for, among them nights with one technique
made a tenth slower, and counts alarms of the time gate.

    bench/nightly_times.py FOLDER [--build build/release] [--unchanged 50] [--slower 10] [--busy 2] [--share 0.1]
                           [--steps N]

The slower technique is fxaa: its filter, compiled into a shader folder of its own (SUBPIXEL_SHADERS), goes through a loop
of idle arithmetic besides, as long as makes the whole technique slower by the share that is asked for, which is set by
measuring and then measured once more. Its image is the same. --busy starts so many processes that compute and pause by
chance all the while. Prints one line a night and a summary; exit code 1 when an unchanged night alarmed or fewer than 9
in 10 slower ones were caught."""
import argparse
import json
import math
import os
import random
import shutil
import statistics
import subprocess
import sys
import time

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..'))
FILTER = 'techniques/fxaa/filter.frag'
PLACE = '  vec4 own = texelFetch(values, pixel, 0);\n'
CONFIG = {
    'name': 'times', 'techniques': 'noaa,msaa:samples=4,fxaa', 'samples': 8, 'size': [128, 72], 'frames': [0, 0],
    'repeat': 7, 'reference_samples': 0, 'captures': [{'scene': 'grass', 'density': 0.05}],
    'gates': {'time': {'slower': 0.03, 'minimum_ms': 1, 'alarm': 0.01, 'rounds': 48}},
}


def burn(seed):
    """Computes for a while, pauses for a while, both by chance."""
    chance = random.Random(seed)
    while True:
        end = time.monotonic() + chance.uniform(0.05, 1.5)
        while time.monotonic() < end:
            sum(i * i for i in range(1000))
        time.sleep(chance.uniform(0.05, 1.5))


class Bench:
    def __init__(self, folder, build):
        self.folder, self.build = os.path.abspath(folder), os.path.abspath(build)
        self.subpixel = os.path.join(self.build, 'subpixel')
        os.makedirs(self.folder, exist_ok=True)
        self.config = os.path.join(self.folder, 'times.json')
        with open(self.config, 'w', encoding='utf-8') as file:
            json.dump(CONFIG, file)
        self.plain, self.slow = os.path.join(self.folder, 'plain'), os.path.join(self.folder, 'slow')
        for shaders in (self.plain, self.slow):
            if not os.path.isdir(shaders):
                shutil.copytree(os.path.join(self.build, 'spirv'), shaders)

    def slow_filter(self, steps):
        with open(os.path.join(ROOT, 'shaders', FILTER), encoding='utf-8') as file:
            source = file.read()
        assert PLACE in source
        idle = (f'  float idle = m; for (uint i = 0u; i < {steps}u; ++i) idle = fract(idle * 1.7 + 0.3);\n'
                '  vec4 own = texelFetch(values, pixel, 0) + vec4(vec3(idle * 1e-35), 0.0);\n')
        path = os.path.join(self.folder, 'filter.frag')
        with open(path, 'w', encoding='utf-8') as file:
            file.write(source.replace(PLACE, idle))
        subprocess.run(['glslangValidator', '-V', '--target-env', 'vulkan1.3', '-I' + os.path.join(ROOT, 'shaders'),
                        '--quiet', '-o', os.path.join(self.slow, FILTER + '.spv'), path], check=True)

    def ratios(self, shaders, rounds, capture):
        """fxaa's processor time over the mean of msaa's and noaa's logarithms, one for each round."""
        out = os.path.join(self.folder, 'out')
        techniques = [{'technique': 'noaa', 'parameters': {}}, {'technique': 'msaa', 'parameters': {'samples': 4}},
                      {'technique': 'fxaa', 'parameters': {}}]
        job = {'capture': capture, 'out_dir': out, 'cache_dir': os.path.join(self.folder, 'cache'),
               'options': {'techniques': techniques, 'samples': 8, 'frames': [0, 0], 'width': 128, 'height': 72,
                           'repeat': 7, 'reference_samples': 0, 'point_lights': None, 'rounds': rounds}}
        path = os.path.join(self.folder, 'job.json')
        with open(path, 'w', encoding='utf-8') as file:
            json.dump(job, file)
        done = subprocess.run([self.subpixel, 'worker', '--job', path], capture_output=True, text=True, check=True,
                              env=dict(os.environ, SUBPIXEL_SHADERS=shaders))
        ms = {}
        for line in done.stdout.splitlines():
            message = json.loads(line)
            if message['type'] == 'result':
                ms.setdefault(message['result']['technique'], []).append(message['result']['ms']['processor'])
        return [math.log(f) - 0.5 * (math.log(m) + math.log(n)) for f, m, n in zip(ms['fxaa'], ms['msaa'], ms['noaa'])]

    def share(self, capture, processes):
        """By how much the slow shaders' fxaa is slower, from so many processes of both in turn, four rounds each."""
        plain, slow = [], []
        for _ in range(processes):
            plain += self.ratios(self.plain, 4, capture)
            slow += self.ratios(self.slow, 4, capture)
        return math.exp(statistics.median(slow) - statistics.median(plain)) - 1

    def tune(self, wanted):
        """Steps of idling that make fxaa slower by `wanted`: a line through what many steps cost, which noise moves
        by a smaller share than what a few cost, and once more from there."""
        capture = os.path.join(self.folder, 'grass.spcap')
        subprocess.run([self.subpixel, 'generate', 'grass', capture, '--frames', '1', '--size', '128x72', '--density',
                        '0.05'], check=True, stdout=subprocess.DEVNULL)
        self.slow_filter(1)
        none = self.share(capture, 6)
        self.slow_filter(1000)
        many = self.share(capture, 6)
        print(f'1 step: fxaa {100 * none:+.1f}%; 1000 steps: {100 * many:+.1f}%', flush=True)
        steps = max(1, round(1000 * wanted / many))
        self.slow_filter(steps)
        return steps, self.share(capture, 10)

    def night(self, shaders, data):
        path = os.path.join(self.folder, 'night.json')
        done = subprocess.run([self.subpixel, 'nightly', '--config', self.config, '--data', data, '--json', path],
                              capture_output=True, text=True, env=dict(os.environ, SUBPIXEL_SHADERS=shaders))
        if done.returncode not in (0, 1):
            sys.exit(done.stderr)
        with open(path, encoding='utf-8') as file:
            return json.load(file)


def cell_of(night, technique):
    return [cell for cell in night['cells'] if cell['technique'] == technique][0]


def log_ratios(night):
    """As Bench.ratios, of a night's rounds."""
    return [math.log(one['ms']) - statistics.mean(math.log(ms) for ms in one['references'].values())
            for one in cell_of(night, 'fxaa')['time']['rounds']]


def failures(night):
    return [(cell['technique'], gate['gate'], gate['detail']) for cell in night['cells'] for gate in cell['gates']
            if gate['outcome'] == 'failed']


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder')
    parser.add_argument('--build', default=os.path.join(ROOT, 'build/release'))
    parser.add_argument('--unchanged', type=int, default=50)
    parser.add_argument('--slower', type=int, default=10)
    parser.add_argument('--busy', type=int, default=2)
    parser.add_argument('--share', type=float, default=0.1)
    parser.add_argument('--steps', type=int, help='of idling, instead of looking for them')
    options = parser.parse_args()
    bench = Bench(options.folder, options.build)
    if options.steps:
        bench.slow_filter(options.steps)
    else:
        steps, measured = bench.tune(options.share)
        print(f'the slower fxaa: {steps} steps of idling, measured {100 * measured:+.1f}%', flush=True)
    burners = [subprocess.Popen([sys.executable, '-c', 'import sys; sys.path.insert(0, sys.argv[1]); import nightly_times;'
                                 f' nightly_times.burn({i})', os.path.dirname(os.path.abspath(__file__))])
               for i in range(options.busy)]
    try:
        return count(bench, options.unchanged, options.slower)
    finally:
        for burner in burners:
            burner.kill()


def count(bench, unchanged, slower):
    """Nights of both kinds, the slower ones spread among the others; the exit code."""
    data, copy = os.path.join(bench.folder, 'data'), os.path.join(bench.folder, 'data_slower')
    shutil.rmtree(data, ignore_errors=True)
    bench.night(bench.plain, data)
    subprocess.run([bench.subpixel, 'baseline', 'set', 'times', '--data', data], check=True, stdout=subprocess.DEVNULL)
    alarms = caught = slower_done = 0
    noises, took, plain, slow = [], [], [], []
    for i in range(unchanged):
        start = time.monotonic()
        night = bench.night(bench.plain, data)
        took.append(time.monotonic() - start)
        noises.append(night['facts']['noise'])
        plain += log_ratios(night)
        failed = failures(night)
        alarms += 1 if failed else 0
        print(f'unchanged {i + 1}: {took[-1]:.1f} s, {night["times"]} {failed or ""}', flush=True)
        while slower_done < slower * (i + 1) // unchanged:
            # Each on a copy: a slow night that passes is not what the next ones are compared with.
            shutil.rmtree(copy, ignore_errors=True)
            shutil.copytree(data, copy)
            night = bench.night(bench.slow, copy)
            slow += log_ratios(night)
            fxaa = cell_of(night, 'fxaa')
            gate = [gate for gate in fxaa['gates'] if gate['gate'] == 'time'][0]
            hit = gate['outcome'] == 'failed'
            caught += 1 if hit else 0
            slower_done += 1
            print(f'slower {slower_done}: {"caught" if hit else "MISSED"}, {len(log_ratios(night))} rounds: '
                  f'{gate["detail"]}', flush=True)
    if not unchanged:
        return 0
    print(f'{unchanged} unchanged nights, {alarms} with an alarm; noise {100 * statistics.median(noises):.1f}% '
          f'({100 * min(noises):.1f} to {100 * max(noises):.1f}%), {statistics.median(took):.1f} s a night')
    if slow:
        share = math.exp(statistics.median(slow) - statistics.median(plain)) - 1
        print(f'fxaa slower by {100 * share:.1f}% (medians of all rounds of all nights): caught in {caught} of {slower} nights')
    return 0 if alarms == 0 and caught >= 0.9 * slower else 1


if __name__ == '__main__':
    sys.exit(main())
