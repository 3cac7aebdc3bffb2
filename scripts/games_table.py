#!/usr/bin/env python3
"""The tables of docs/games.md, in Markdown, of replays of one frame each:

    scripts/games_table.py NAME=RESULTS.json...

RESULTS.json is what `subpixel replay --json` writes: the same techniques each time, among them noaa and msaa.
"""
import json
import sys

# What the publications claim, and the figure that shows it: errors and lighting executions of one technique over those
# of another, at most this much.
CLAIMS = [
    ("A few surfaces a pixel are as good as all samples (`sbaa`)", "mse", "sbaa", "msaa", 1.1),
    ("The same, merged as they come (`streaming`)", "mse", "streaming", "msaa", 1.1),
    ("The same, as aggregates (`agaa`)", "mse", "agaa", "msaa", 1.1),
    ("A list of all fragments loses nothing (`linked_list`)", "mse", "linked_list", "msaa", 1.02),
    ("Triangles' numbers and depths lose nothing (`visibility`)", "mse", "visibility", "msaa", 1.02),
    ("A triangle buffer loses nothing (`dais`)", "mse", "dais", "visibility", 1.02),
    ("Finer coverage beats the samples (`dcaa`)", "mse", "dcaa", "msaa", 1.0),
    ("Aggregates of full lists beat it (`hybrid`)", "mse", "hybrid", "dcaa", 1.0),
    ("An image filter helps (`fxaa`)", "mse", "fxaa", "noaa", 0.9),
    ("Revectorised outlines help more (`smaa`)", "mse", "smaa", "fxaa", 1.0),
    ("Accumulated frames help (`taa`)", "mse", "taa", "noaa", 0.9),
    ("Pixels whose samples agree need one lighting (`simple_complex`)", "lit", "simple_complex", "msaa", 0.5),
    ("A surface needs one lighting (`sbaa`)", "lit", "sbaa", "msaa", 0.25),
    ("An aggregate needs one lighting (`agaa`)", "lit", "agaa", "msaa", 0.25),
    ("A visible triangle needs one lighting (`visibility`)", "lit", "visibility", "msaa", 0.25),
]


def label(result, all_results):
    """The technique, with the parameters that set it apart from others of its name."""
    same = [r for r in all_results if r["technique"] == result["technique"]]
    apart = [key for key, value in sorted(result["parameters"].items())
             if any(r["parameters"].get(key) != value for r in same[:1])]
    return ":".join([result["technique"]] + ["{}={}".format(key, result["parameters"][key]) for key in apart])


def read(path):
    """{label: figures} in the order of the replay."""
    with open(path) as file:
        results = json.load(file)["results"]
    return {label(r, results): {"mse": r["error"]["mse"], "flip": r["error"]["flip_mean"],
                                "lit": r["shading"]["per_pixel_mean"], "paper": r["memory"]["paper_bytes_per_pixel"],
                                "fitted": r["memory"]["fitted_bytes_per_pixel"]} for r in results}


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def of_techniques(frames, cell):
    techniques = list(next(iter(frames.values())))
    return table(["technique"] + list(frames), [
        ["`{}`".format(t)] + [cell(frame, t) for frame in frames.values()] for t in techniques])


def claims(frames):
    rows = []
    for text, figure, test, against, most in CLAIMS:
        ratios = [frame[test][figure] / frame[against][figure] for frame in frames.values()]
        holds = sum(ratio <= most for ratio in ratios)
        rows.append([text, "{} of `{}`".format("error" if figure == "mse" else "lighting", against),
                     "{:g}".format(most)] + ["{:.2f}".format(ratio) for ratio in ratios] +
                    ["yes" if holds == len(ratios) else "no" if holds == 0 else "on {} of {}".format(holds, len(ratios))])
    return table(["claim", "times the", "at most"] + list(frames) + ["holds"], rows)


def main(arguments):
    if not arguments or any("=" not in argument for argument in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    frames = dict((name, read(path)) for name, path in (argument.split("=", 1) for argument in arguments))
    print("Mean squared error x 10^4, and times that of `msaa`:\n")
    print(of_techniques(frames, lambda frame, t: "{:.2f} ({:.2f})".format(
        1e4 * frame[t]["mse"], frame[t]["mse"] / frame["msaa"]["mse"])))
    print("Mean FLIP x 1000:\n")
    print(of_techniques(frames, lambda frame, t: "{:.2f}".format(1e3 * frame[t]["flip"])))
    print("Lighting executions a pixel:\n")
    print(of_techniques(frames, lambda frame, t: "{:.2f}".format(frame[t]["lit"])))
    print("Bytes a pixel, the publication's format and as measured in formats fitted to the frame:\n")
    print(of_techniques(frames, lambda frame, t: "{:.0f}, {:.0f}".format(frame[t]["paper"], frame[t]["fitted"])))
    print("Do the publications' claims hold?\n")
    print(claims(frames), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
