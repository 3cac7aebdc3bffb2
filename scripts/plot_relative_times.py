#!/usr/bin/env python3
"""Plots frame times relative to `noaa` of the same run, as an SVG: over samples, and over point lights.

    plot_relative_times.py OUT.svg RESULTS.json...

Each results file holds `noaa` and any of `msaa` and `linked_list` at several sample counts; files differ in lights.
The left plot is made of the file with most lights up to 50, the right one of 8x (msaa also 4x) in all files.
"""
import json
import sys

COLOURS = {"msaa": "#c0392b", "msaa 4x": "#e08e79", "msaa 8x": "#c0392b", "linked_list": "#2471a3",
           "linked_list 4x": "#85c1e9", "linked_list 8x": "#2471a3"}
WIDTH, HEIGHT, LEFT, TOP, GAP = 300, 220, 46, 28, 120


def relative_times(path):
    with open(path) as file:
        content = json.load(file)
    times = {(r["technique"], r["samples"]): r["ms"]["total"] for r in content["results"]}
    base = times[("noaa", 1)]
    return content["head"]["point_lights"], {key: value / base for key, value in times.items()}


def panel(x0, title, label, curves):
    xs = sorted({x for points in curves.values() for x, _ in points})
    top = max(y for points in curves.values() for _, y in points) * 1.1
    place_x = lambda x: x0 + WIDTH * (xs.index(x) + 0.5) / len(xs)
    place_y = lambda y: TOP + HEIGHT * (1 - y / top)
    parts = [f'<text x="{x0}" y="{TOP - 10}" font-weight="bold">{title}</text>',
             f'<path d="M{x0} {TOP}V{TOP + HEIGHT}H{x0 + WIDTH}" fill="none" stroke="#444"/>',
             f'<text x="{x0 + WIDTH / 2}" y="{TOP + HEIGHT + 34}" text-anchor="middle">{label}</text>']
    for x in xs:
        parts.append(f'<text x="{place_x(x):.1f}" y="{TOP + HEIGHT + 16}" text-anchor="middle">{x}</text>')
    for tick in range(1, int(top) + 1):
        parts.append(f'<path d="M{x0} {place_y(tick):.1f}h{WIDTH}" stroke="#ddd"/>')
        parts.append(f'<text x="{x0 - 6}" y="{place_y(tick) + 4:.1f}" text-anchor="end">{tick}</text>')
    for name, points in sorted(curves.items()):
        line = " ".join(f"{place_x(x):.1f},{place_y(y):.1f}" for x, y in points)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{COLOURS[name]}" stroke-width="2"/>')
        for x, y in points:
            parts.append(f'<circle cx="{place_x(x):.1f}" cy="{place_y(y):.1f}" r="3" fill="{COLOURS[name]}"/>')
        x, y = points[-1]
        parts.append(f'<text x="{place_x(x) + 7:.1f}" y="{place_y(y) + 4:.1f}" fill="{COLOURS[name]}">{name}</text>')
    return parts


def main():
    runs = sorted((relative_times(path) for path in sys.argv[2:]), key=lambda run: run[0])
    by_samples = max((run for run in runs if run[0] <= 50), key=lambda run: run[0])
    left = {name: sorted((n, y) for (technique, n), y in by_samples[1].items() if technique == name)
            for name in ("msaa", "linked_list")}
    right = {f"{technique} {n}x": [(lights, times[(technique, n)]) for lights, times in runs]
             for technique in ("msaa", "linked_list") for n in (4, 8)}
    parts = panel(LEFT, f"{by_samples[0]} lights: frame over noaa", "samples per pixel", left)
    parts += panel(LEFT + WIDTH + GAP, "frame over noaa", "point lights", right)
    width, height = LEFT + 2 * WIDTH + GAP + 110, TOP + HEIGHT + 44
    with open(sys.argv[1], "w") as file:
        file.write(f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
                   f'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="#fff"/>\n')
        file.write("\n".join(parts) + "\n</svg>\n")


if __name__ == "__main__":
    main()
