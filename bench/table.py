#!/usr/bin/env python3
"""Rows of scenes, columns of settings, from results that `subpixel replay --json` wrote: the tables of docs/techniques.

    bench/table.py FILE... --settings "msaa:samples=8,agaa:aggregates=2" [--number mse] [--over SETTING] [--settings-down]
                   [--subpixel build/release/subpixel]

--over: cells are MSE / FLIP / executions / time over that setting's, of its run. --settings-down: settings are the rows.
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


def is_setting(result, setting):
    technique, wanted = setting
    own = {name: text(value) for name, value in result['parameters'].items()}
    return result['technique'] == technique and all(wanted.get(name, value) == value for name, value in own.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('files', nargs='+')
    parser.add_argument('--settings', required=True)
    parser.add_argument('--number', default='mse')
    parser.add_argument('--over')
    parser.add_argument('--settings-down', action='store_true')
    parser.add_argument('--subpixel', default='build/release/subpixel')
    options = parser.parse_args()
    defaults = registry(options.subpixel)
    settings = {setting: parse(setting, defaults) for setting in options.settings.split(',')}
    over = parse(options.over, defaults) if options.over else None
    rows = {}
    for file in options.files:
        with open(file, encoding='utf-8') as stream:
            told = json.load(stream)
        cells = rows.setdefault(told['head']['capture_title'], {})
        base = next((r['ms']['total'] for r in told['results'] if over and is_setting(r, over)), None)
        for result in told['results']:
            for setting, wanted in settings.items():
                if not is_setting(result, wanted):
                    continue
                if not over:
                    cells[setting] = number_of(result, options.number)
                elif base:
                    numbers = [number_of(result, number) for number in ('mse', 'flip', 'executions')]
                    cells[setting] = ' / '.join(numbers + [f"{result['ms']['total'] / base:.2f}"])
    lines = [[''] + [f'`{s}`' for s in settings]]
    lines += [[f'`{scene}`'] + [cells.get(s, '') for s in settings] for scene, cells in rows.items()]
    if options.settings_down:
        lines = list(zip(*lines))
    lines.insert(1, ['---'] * len(lines[0]))
    for line in lines:
        print('| ' + ' | '.join(line) + ' |')


if __name__ == '__main__':
    main()
