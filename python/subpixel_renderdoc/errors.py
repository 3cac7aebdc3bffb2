"""The one error of this package, and the module that may be missing."""
import os


class ExportError(Exception):
    """What can't be exported or recorded: `what: why: where` in one line."""

    def __init__(self, what, why, where=""):
        text = ": ".join(" ".join(str(part).split()) for part in (what, why, where) if part)
        super().__init__(text)


def renderdoc_module():
    """RenderDoc's Python module: built in in qrenderdoc, python3-renderdoc on Debian."""
    if "DISPLAY" not in os.environ:
        # RenderDoc then replays OpenGL by EGL, whose platform without windows Mesa has.
        os.environ.setdefault("EGL_PLATFORM", "surfaceless")
    try:
        import renderdoc
    except ImportError as error:
        raise ExportError("RenderDoc captures can't be read here", "Python has no module renderdoc ({}); Debian's "
                          "package is python3-renderdoc, and only the system's python3 finds it".format(error))
    return renderdoc
