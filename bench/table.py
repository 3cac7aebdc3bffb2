#!/usr/bin/env python3
"""Rows of scenes, columns of settings, from results that `subpixel replay --json` wrote: the tables of docs/techniques.

    bench/table.py FILE... --settings "msaa:samples=8,agaa:aggregates=2" [--number mse] [--subpixel build/release/subpixel]

Settings as in `subpixel replay --techniques`, without lists of values; what one does not name is at its default. Several files of a
scene are read as one. Numbers: mse (1e-4), flip, executions (a pixel), and any counter (a pixel). A setting that no file of the
scene has is an empty cell."""
import argparse
import json
import subprocess
import sys


def registry(subpixel):
    told = json.loads(subprocess.run([subpixel, 'techniques', '--json'], check=True, capture_output=True, text=True).stdout)
    return {t['name']: {p['name']: p['default'] for p in t['parameters']} for t in told}


def text(value):
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    return json.dumps(value) if isinstance(value, bool) else str(value)


def parse(setting, defaults):
    """(technique, all its parameters as text)."""
    technique, *given = setting.split(':')
    if technique not in defaults:
        sys.exit(f'{setting}: there is no technique {technique}')
    parameters = {name: text(value) for name, value in defaults[technique].items()}
    for part in given:
        name, _, value = part.partition('=')
        if name not in parameters:
            sys.exit(f'{setting}: {technique} has no parameter {name}')
        parameters[name] = value
    return technique, parameters


def number_of(result, number):
    pixels = result['width'] * result['height']
    if number == 'mse':
        return f"{1e4 * result['error']['mse']:.2f}"
    if number == 'flip':
        return f"{result['error']['flip_mean']:.4f}"
    if number == 'executions':
        return f"{result['shading']['per_pixel_mean']:.3f}"
    return f"{result['counters'][number] / pixels:.4f}" if number in result['counters'] else ''


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('files', nargs='+')
    parser.add_argument('--settings', required=True)
    parser.add_argument('--number', default='mse')
    parser.add_argument('--subpixel', default='build/release/subpixel')
    options = parser.parse_args()
    defaults = registry(options.subpixel)
    settings = {setting: parse(setting, defaults) for setting in options.settings.split(',')}
    rows = {}
    for file in options.files:
        with open(file, encoding='utf-8') as stream:
            told = json.load(stream)
        cells = rows.setdefault(told['head']['capture_title'], {})
        for result in told['results']:
            own = {name: text(value) for name, value in result['parameters'].items()}
            for setting, (technique, wanted) in settings.items():
                if result['technique'] == technique and all(wanted.get(n, v) == v for n, v in own.items()):
                    cells[setting] = number_of(result, options.number)
    print('| ' + ' | '.join(['scene'] + [f'`{s}`' for s in settings]) + ' |')
    print('|' + ' --- |' * (len(settings) + 1))
    for scene, cells in rows.items():
        print('| ' + ' | '.join([f'`{scene}`'] + [cells.get(s, '') for s in settings]) + ' |')


if __name__ == '__main__':
    main()
