"""Run a design's plant and controller as a compiled process behind a pseudo-terminal."""

from __future__ import annotations

import os
import pty
import shutil
import subprocess
import tempfile
import tty
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from .sources import Port, SourceError, from_descriptor

__all__ = ["simulated"]

COMPILE_S = 60.0  # how long the compiler may take


@contextmanager
def simulated(files: Mapping[str, str], samples: int, *, lost: float = 0.0, jitter: float = 0.0, paced: bool = True,
              driven: bool = False, knocks: int = 0) -> Iterator[Port]:
    """Bytes of the simulated device. Raises SourceError without a C compiler.

    One that is `driven` takes u from lines. After each `knocks` samples the first state is added to the present one.
    """
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise SourceError("The simulated device needs a C compiler; install gcc.")
    with tempfile.TemporaryDirectory(prefix="observer-lab-") as folder:
        for name, words in files.items():
            (Path(folder) / name).write_text(words, encoding="utf-8")
        built = subprocess.run([compiler, "-O2", "-std=c99", "-ffp-contract=off", "-o", "plant", "plant.c", "lab.c", "-lm"], cwd=folder,
                               capture_output=True, text=True, timeout=COMPILE_S)
        if built.returncode:
            raise SourceError(f"The compiler refuses the simulated device: {built.stderr[:200]}")
        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        asked = (str(samples), repr(lost), repr(jitter), str(int(paced)), str(int(driven)), str(knocks))
        process = subprocess.Popen([str(Path(folder) / "plant"), *asked], stdout=theirs, stdin=theirs if driven else subprocess.DEVNULL)
        try:
            os.close(theirs)
            with from_descriptor(ours, answers=driven) as port:
                yield port
        finally:
            process.terminate()
            process.wait()
            os.close(ours)
