"""python3 -m subpixel_renderdoc FRAME.rdc [MORE.rdc ...] OUT.spcap"""
import argparse
import json
import os
import sys
import traceback

from subpixel_capture import CaptureError

from .errors import ExportError
from .export import Options, export_files


def _events(text):
    first, _, last = text.partition("-")
    return int(first), int(last or first)


def _direction(text):
    numbers = tuple(float(part) for part in text.split(","))
    if len(numbers) != 3 or not any(numbers):
        raise ValueError(text)
    return numbers


def _mapping(path):
    try:
        with open(path) as file:
            mapping = json.load(file)
    except (OSError, ValueError) as error:
        raise ExportError("the texture mapping can't be read", str(error), path)
    roles = ("base_colour", "normal", "metallic_roughness", "emissive")
    if not isinstance(mapping, dict) or not all(
            role in roles and isinstance(wanted, list) and all(isinstance(w, (int, str)) for w in wanted)
            for role, wanted in mapping.items()):
        raise ExportError("the texture mapping can't be read", "it is no object of {} with lists of names and slots"
                          .format(", ".join(roles)), path)
    return mapping


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="subpixel_renderdoc", description="RenderDoc captures to a .spcap capture")
    parser.add_argument("captures", nargs="+", metavar="FRAME.rdc", help="a frame each, in order")
    parser.add_argument("out", metavar="OUT.spcap")
    parser.add_argument("--events", type=_events, metavar="FIRST-LAST", help="only draws of these event ids")
    parser.add_argument("--target", help="id of the depth target that is the main view's")
    parser.add_argument("--textures", metavar="FILE", help='JSON: {"base_colour": ["name as a pattern", slot], ...}')
    parser.add_argument("--sun", type=_direction, metavar="X,Y,Z", help="a sun that shines this way; default: none")
    parser.add_argument("--title", default="")
    parser.add_argument("--application", default="")
    parser.add_argument("--licence", default="")
    parser.add_argument("--json", action="store_true", help="messages as JSON documents, a line each")
    options = parser.parse_args(arguments)

    def say(kind, text):
        if options.json:
            print(json.dumps({"type": kind, "text": text}), flush=True)
        else:
            print(text if kind == "progress" else "subpixel_renderdoc: " + text, file=sys.stderr, flush=True)

    try:
        wanted = Options(events=options.events, target=options.target, sun=options.sun,
                         mapping=_mapping(options.textures) if options.textures else {},
                         title=options.title or os.path.splitext(os.path.basename(options.captures[0]))[0],
                         application=options.application, licence=options.licence,
                         progress=lambda line: say("progress", line))
        export_files(options.captures, options.out, wanted)
        return 0
    except (ExportError, CaptureError) as error:
        say("error", str(error))
        return 3
    except OSError as error:
        say("error", "can't write the capture: {}: {}".format(error.strerror or error, options.out))
        return 3
    except MemoryError:
        say("error", "the RenderDoc capture can't be exported: memory ran out: {}".format(options.captures[0]))
        return 3
    except Exception as error:  # what RenderDoc hands out may be anything: one line with the place, for a report
        place = traceback.extract_tb(sys.exc_info()[2])[-1]
        say("error", "the RenderDoc capture can't be exported: {} {}: {} line {}: {}".format(
            type(error).__name__, error, os.path.basename(place.filename), place.lineno, options.captures[0]))
        return 3


if __name__ == "__main__":
    sys.exit(main())
