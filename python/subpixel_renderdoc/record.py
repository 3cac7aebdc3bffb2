"""Starts an application under RenderDoc, captures consecutive frames and ends it.

    python3 -m subpixel_renderdoc.record [--frame N | --delay SECONDS] [--frames COUNT] OUT_PREFIX PROGRAM ARGUMENTS...

writes OUT_PREFIX_0.rdc, OUT_PREFIX_1.rdc, ... Needs the module `renderdoc`; OpenGL needs a display (Xvfb will do).
"""
import argparse
import os
import shutil
import signal
import sys
import time

from .errors import ExportError, renderdoc_module


def record(prefix, command, frame=None, delay_s=0.0, count=1, timeout_s=120.0, folder=".", say=None):
    """Paths of the captures. `frame` is the number of the first one, from 0; without, `delay_s` after the start.
    Raises ExportError when the application does not start, presents nothing or ends before its frames are taken."""
    rd = renderdoc_module()
    say = say or (lambda text: None)
    program = shutil.which(command[0]) if os.sep not in command[0] else os.path.abspath(command[0])
    if not program or not os.access(program, os.X_OK):
        raise ExportError("can't record the application", "there is no such program", command[0])
    options = rd.GetDefaultCaptureOptions()
    options.hookIntoChildren = True
    options.refAllResources = False
    arguments = " ".join(_quoted(argument) for argument in command[1:])
    started = rd.ExecuteAndInject(program, folder, arguments, [], prefix, options, False)
    if started.ident == 0:
        raise ExportError("can't record the application", started.result.Message(), program)
    control = _connect(rd, started.ident, program)
    process = control.GetPID()
    try:
        end = time.monotonic() + timeout_s
        apis = {}
        if frame is None:
            _listen(rd, control, time.monotonic() + delay_s, lambda: False, say, None, apis)
            control.TriggerCapture(count)
        else:
            control.QueueCapture(frame, count)
        found = []

        def is_done():
            return len(found) >= count

        _listen(rd, control, end, is_done, say, found, apis)
        if not is_done():
            raise ExportError("can't record the application", "{} of {} frames came within {:g} s{}".format(
                len(found), count, timeout_s, _shown_by(apis)), program)
        return _renamed(found, prefix)
    finally:
        control.Shutdown()
        _end(process)


def _quoted(argument):
    if argument and not any(c in argument for c in " \t\"'\\"):
        return argument
    return '"' + argument.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _connect(rd, ident, program):
    for _ in range(100):
        control = rd.CreateTargetControl("", ident, "subpixel", True)
        if control is not None:
            return control
        time.sleep(0.1)
    raise ExportError("can't record the application", "it ended at once, or RenderDoc could not enter it", program)


def _shown_by(apis):
    """What RenderDoc says of the interfaces that the application draws with: why no frame may come."""
    if not apis:
        return "; RenderDoc saw it draw by no interface that it knows"
    return "".join("; {}: {}".format(name, "it shows no frames" if supported and not presenting else
                                     "frames are shown" if supported else
                                     "RenderDoc can't capture it" + (": " + why if why else ""))
                   for name, (presenting, supported, why) in sorted(apis.items()))


def _listen(rd, control, end, is_done, say, found=None, apis=None):
    kinds = rd.TargetControlMessageType
    while time.monotonic() < end and not is_done():
        message = control.ReceiveMessage(None)
        if message.type == kinds.NewCapture and found is not None:
            found.append((message.newCapture.frameNumber, message.newCapture.path))
            say("captured frame {} ({:.1f} MB)".format(message.newCapture.frameNumber,
                                                       message.newCapture.byteSize / 1e6))
        elif message.type == kinds.RegisterAPI and apis is not None:
            use = message.apiUse
            apis[use.name] = (use.presenting, use.supported, use.supportMessage)
        elif message.type == kinds.Disconnected:
            raise ExportError("can't record the application", "it ended before its frames were taken")
        elif message.type == kinds.Noop:
            time.sleep(0.01)


def _renamed(found, prefix):
    paths = []
    for number, (_, path) in enumerate(sorted(found)):
        target = "{}_{}.rdc".format(prefix, number)
        os.replace(path, target)
        paths.append(target)
    return paths


def _end(process):
    for sent in (signal.SIGTERM, signal.SIGKILL):
        for _ in range(30):
            try:
                os.kill(process, sent if _ == 0 else 0)
            except (ProcessLookupError, PermissionError):
                return
            time.sleep(0.1)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="subpixel_renderdoc.record", description=__doc__.split("\n")[0])
    parser.add_argument("--frame", type=int, help="number of the first frame, from 0")
    parser.add_argument("--delay", type=float, default=0.0, help="seconds after the start, where no number is given")
    parser.add_argument("--frames", type=int, default=1, help="how many consecutive ones")
    parser.add_argument("--timeout", type=float, default=120.0, help="seconds to wait for them")
    parser.add_argument("--folder", default=".", help="where the application runs")
    parser.add_argument("prefix")
    parser.add_argument("command", nargs=argparse.REMAINDER)
    options = parser.parse_args(arguments)
    if not options.command:
        parser.error("which program?")
    try:
        paths = record(os.path.abspath(options.prefix), options.command, options.frame, options.delay, options.frames,
                       options.timeout, options.folder, lambda text: print(text, file=sys.stderr))
    except ExportError as error:
        print("subpixel_renderdoc: {}".format(error), file=sys.stderr)
        return 3
    for path in paths:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
