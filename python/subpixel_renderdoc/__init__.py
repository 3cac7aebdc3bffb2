"""RenderDoc captures to Subpixel's: the opaque and alpha-tested draws of a frame's main view, whatever API drew them.

In qrenderdoc's Python shell, with a capture open and this package's folder on sys.path:

    import subpixel_renderdoc
    subpixel_renderdoc.export_open_capture(pyrenderdoc, "C:/frames/harbour.spcap")

On a command line: python3 -m subpixel_renderdoc frame.rdc out.spcap. See docs/recording.md.
"""
from .errors import ExportError
from .export import Options, export_files, export_open_capture

__all__ = ["ExportError", "Options", "export_files", "export_open_capture"]
