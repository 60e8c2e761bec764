"""Try lessons, commands, odd plants and odd knobs: exit status 0, 1 or 2, one sentence, no traceback; `python tests/refusals.py 200`."""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

from observer_lab.cli.entry import main
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import EXAMPLES

COMMANDS = (("run",), ("run", "--json"), ("link",), ("export", "--to", "json"), ("export", "--to", "python"))
ODD = ("nan", "inf", "-1e308", "1e308", "0", "-1", "", "x", "[]", "1,1,1", "0.5", "-0.5,-0.5", "1e-300", "٣")
PLANTS: tuple[dict[str, object], ...] = (
    {"A": [[0, 0], [0, 0]], "B": [[1], [2]], "C": [[1, 0]]}, {"A": [[1]], "B": [[0]], "C": [[0]]},
    {"A": [[1, 1], [0, 1]], "B": [[0], [1]], "C": [[1, 0]], "Ts": 1}, {"A": [[0]], "B": [[1]], "C": [[1]], "Ts": 0.1},
    {"A": [[1e9, 0], [0, -1e-9]], "B": [[1], [1]], "C": [[1, 1]]}, {"num": [1], "den": [1, 0, 0, 0]}, {"num": [1], "den": [1]},
    {"A": [[-1, 0], [0, -1]], "B": [[1, 0], [0, 1]], "C": [[1, 0], [0, 1]], "InputDelay": [0.1, 0.2]}, {"A": "x"}, {"E": 1})


def tried(seed: int, folder: Path) -> tuple[list[str], int, str]:
    """One drawn command line, its exit status and what it said on standard error."""
    rng = np.random.default_rng(seed)
    lesson = LESSONS[str(rng.choice(list(LESSONS)))]
    command = COMMANDS[int(rng.integers(len(COMMANDS)))]
    words = [command[0], lesson.id, *command[1:]]
    if command[0] == "export":
        words += ["-o", str(folder / f"out{seed}")]
    kind = rng.integers(3)
    if kind == 0:
        (folder / f"{seed}.json").write_text(json.dumps(PLANTS[int(rng.integers(len(PLANTS)))]), encoding="utf-8")
        words += ["--plant", str(folder / f"{seed}.json")]
    elif kind == 1:
        words += ["--plant", str(rng.choice([*EXAMPLES, "none", ".", "/dev/null"]))]
    for _ in range(int(rng.integers(0, 3))):
        knob = lesson.knobs[int(rng.integers(len(lesson.knobs)))]
        words += ["--set", f"{knob.name}={rng.choice(ODD)}"]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(words)
    return words, status, err.getvalue()


def fault(seed: int, folder: Path) -> str:
    """What breaks the law, "" where nothing does."""
    words, status, said = tried(seed, folder)
    wrong = status not in (0, 1, 2) or "Traceback" in said or (status == 2) != bool(said.strip()) or (status == 2 and said.count("\n") != 1)
    return f"{seed}: {' '.join(words)} gave {status}: {said.strip()[:300]}" if wrong else ""


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as name:
        count = int(sys.argv[1]) if len(sys.argv) > 1 else 100
        found = [said for said in (fault(seed, Path(name)) for seed in range(count)) if said]
    print("\n".join(found), f"{count} command lines, {len(found)} faults", sep="\n")
    sys.exit(bool(found))
