#!/usr/bin/env python3
"""How time and memory grow with the triangles of a frame, its pixels, its lights and its draws.

    bench/scaling.py FOLDER [--build build/release] [--sweeps triangles,pixels,lights,draws] [--techniques a,b]
                     [--repeat 1] [--largest 10]

Makes the captures in FOLDER (kept for the next time), replays each point in a process of its own and prints a table in
Markdown for each sweep: processor milliseconds of all threads of a warm frame and MiB that its passes hold at a time, by
technique, and the seconds and the largest resident MiB of the whole process. Behind them the exponent between
the points: how many times the figure grows over how many times the quantity does, as logarithms, least squares, and
the largest between neighbours. Processor time stands other work on the machine well, not perfectly. --largest: millions
of triangles."""
import argparse
import json
import math
import os
import resource
import subprocess
import sys
import time

TECHNIQUES = 'msaa,streaming,dcaa,agaa,linked_list,simple_complex,visibility'
SIZES = [(0.25, '672x378'), (1, '1344x756'), (4, '2688x1512'), (8, '3792x2133')]


def run(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.monotonic()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return time.monotonic() - began, processor


def replay(options, capture, size, lights):
    """A point: {technique: (processor ms, MiB held)}, and of the process processor seconds and resident MiB."""
    out = os.path.join(options.folder, 'out')
    command = [os.path.join(options.build, 'subpixel'), 'replay', capture, '--techniques', options.techniques, '--frames',
               '0-0', '--size', size, '--repeat', str(options.repeat), '--reference-samples', '0', '--out', out]
    if lights is not None:
        command += ['--lights', str(lights)]
    # The largest of all children is what the system keeps: each point is asked for by a child of its own.
    script = ('import json,resource,subprocess,sys\n'
              'subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)\n'
              'used = resource.getrusage(resource.RUSAGE_CHILDREN)\n'
              'print(json.dumps([used.ru_utime + used.ru_stime, used.ru_maxrss / 1024]))\n')
    answer = subprocess.run([sys.executable, '-c', script] + command, check=True, stdout=subprocess.PIPE)
    processor, resident = json.loads(answer.stdout)
    with open(os.path.join(out, 'results.json')) as file:
        results = json.load(file)
    point = {}
    for result in results['results']:
        memory = result['memory']
        point[result['technique']] = (result['ms']['processor'], memory['peak_bytes'] / 2**20)
    return point, results['head']['triangles_first_frame'], processor, resident


def exponents(points):
    """Of (quantity, figure): least squares over all, and the largest between neighbours."""
    logs = [(math.log(x), math.log(max(y, 1e-9))) for x, y in points]
    mean = [sum(values) / len(logs) for values in zip(*logs)]
    slope = (sum((x - mean[0]) * (y - mean[1]) for x, y in logs) / sum((x - mean[0])**2 for x, _ in logs))
    steps = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(logs, logs[1:])]
    return slope, max(steps)


def capture_of(options, name, make):
    path = os.path.join(options.folder, name + '.spcap')
    if not os.path.exists(path):
        run(make(path))
    return path


def generated(options, scene, density):
    return capture_of(options, f'{scene}_{density}',
                      lambda path: [os.path.join(options.build, 'subpixel'), 'generate', scene, path, '--frames', '1',
                                    '--density', str(density)])


def drawn(options, draws, textures):
    return capture_of(options, f'draws_{draws}_{textures}',
                      lambda path: [os.path.join(options.build, 'bench', 'subpixel_bench_captures'), 'draws', str(draws),
                                    str(textures), path])


def sweep(options, name):
    """Yields label, quantity (None: the triangles that the replay counts), capture, size, lights."""
    if name == 'triangles':
        for millions in (0.1, 1, 10):
            if millions <= options.largest:
                yield f'{millions} million', None, generated(options, 'grass', 3.75 * millions), '640x360', 32
    elif name == 'pixels':
        for megapixels, size in SIZES:
            yield f'{size} ({megapixels} megapixels)', megapixels, generated(options, 'city', 1), size, 32
    elif name == 'lights':
        for lights in (1, 32, 1024):
            yield f'{lights}', lights, generated(options, 'city', 1), '640x360', lights
    elif name == 'draws':
        for draws, textures in ((50, 5), (500, 50), (5000, 500)):
            yield f'{draws} draws, {textures} textures', draws, drawn(options, draws, textures), '640x360', 4
    else:
        sys.exit(f'no such sweep: {name}')


def table(options, name):
    columns, rows = options.techniques.split(','), []
    for label, quantity, capture, size, lights in sweep(options, name):
        point, triangles, processor, resident = replay(options, capture, size, lights)
        rows.append((label, quantity or triangles, point, processor, resident))
        print(f'{name}: {label}', file=sys.stderr)
    lines = [f'| {name} | ' + ' | '.join(columns) + ' | process, s | resident, MiB |',
             '| --- |' + ' --- |' * (len(columns) + 2)]
    for label, _, point, processor, resident in rows:
        cells = [f'{point[c][0]:.0f} ms, {point[c][1]:.0f} MiB' for c in columns]
        lines.append(f'| {label} | ' + ' | '.join(cells) + f' | {processor:.1f} | {resident:.0f} |')
    if len(rows) > 1:
        def of(figure):
            slope, most = exponents([(row[1], figure(row)) for row in rows])
            return f'{slope:.2f} ({most:.2f})'
        cells = [of(lambda row: row[2][c][0]) + ', ' + of(lambda row: row[2][c][1]) for c in columns]
        lines.append('| exponent: all (largest step); time, memory | ' + ' | '.join(cells) + ' | ' +
                     of(lambda row: row[3]) + ' | ' + of(lambda row: row[4]) + ' |')
    return '\n'.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('folder')
    parser.add_argument('--build', default=os.path.join(os.path.dirname(__file__), '..', 'build', 'release'))
    parser.add_argument('--sweeps', default='triangles,pixels,lights,draws')
    parser.add_argument('--techniques', default=TECHNIQUES)
    parser.add_argument('--repeat', type=int, default=1)
    parser.add_argument('--largest', type=float, default=10)
    options = parser.parse_args()
    os.makedirs(options.folder, exist_ok=True)
    for name in options.sweeps.split(','):
        print(table(options, name) + '\n', flush=True)


if __name__ == '__main__':
    main()
