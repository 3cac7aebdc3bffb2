"""The one error of this package."""


class CaptureError(ValueError):
    """A capture that can't be read or written: `what: why: where` in one line, as `subpixel` says it."""

    def __init__(self, what, why, where=""):
        super().__init__(": ".join(part for part in (what, why, where) if part))
        self.what, self.why, self.where = what, why, where
