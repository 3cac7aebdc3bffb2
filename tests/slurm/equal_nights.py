#!/usr/bin/env python3
"""Whether the newest nights of two data folders measured the same, bit for bit: every document but its times, and the
images by content hash. Prints how many frames and images were compared.
    equal_nights.py DATA DATA      exit code 1 and the first differences when they are not the same"""
import json
import sqlite3
import sys


def night(folder):
    store = sqlite3.connect(f"file:{folder}/subpixel.sqlite?mode=ro", uri=True)
    (newest,) = store.execute("SELECT max(id) FROM nights").fetchone()
    captures = store.execute("SELECT name, hash, problem, head FROM night_captures WHERE night = ? ORDER BY ordinal",
                             (newest,)).fetchall()
    read = {}
    for name, content, problem, head in captures:
        head = json.loads(head) if head else {}
        for times in ("date_utc", "wall_s", "outside_gpu_s", "outside_parts_s"):
            head.pop(times, None)
        head.pop("peak_bytes", None)  # of a process, which draws a shard or all
        read[f"capture {name}"] = [content, problem, head]
    frames = store.execute("SELECT n.name, c.technique, f.frame, f.document FROM night_cells c JOIN night_captures n ON "
                           "n.night = c.night AND n.ordinal = c.capture JOIN night_frames f ON f.cell = c.id WHERE "
                           "c.night = ? ORDER BY f.id", (newest,)).fetchall()
    for name, technique, frame, document in frames:
        document = json.loads(document)
        del document["ms"]
        read[f"{name} {technique} frame {frame}"] = document
    images = sum(len(document["images"]) for document in read.values() if isinstance(document, dict))
    return read, len(frames), images


def main():
    (a, frames, images), (b, _, _) = (night(folder) for folder in sys.argv[1:3])
    differ = [key for key in dict.fromkeys([*a, *b]) if a.get(key) != b.get(key)]
    for key in differ[:10]:
        print(f"differs: {key}\n  {a.get(key)}\n  {b.get(key)}")
    if not differ and list(a) != list(b):
        differ = ["the order"]
        print("the same results in another order")
    print(f"{frames} frames, {images} images")
    return 1 if differ or frames == 0 else 0


sys.exit(main())
