"""A process of a test that outlives no test."""

from __future__ import annotations

import subprocess
from types import TracebackType


class Served(subprocess.Popen[str]):
    """Killed where a test has not seen it end: leaving the context would wait for it, and the whole suite with it."""

    told = ("", "")  # what it has printed, and what it has logged, after its end

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None) -> None:
        if self.poll() is None:
            self.kill()
        super().__exit__(kind, value, traceback)
