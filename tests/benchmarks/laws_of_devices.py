"""The law of exported designs: random designs of every lesson give the same bits in every body.

`python tests/benchmarks/laws_of_devices.py [--designs 20] [LESSON …]` prints a row for each lesson: designs tried and refused, and how many
differ in gcc -O0, gcc -O3, the sanitizers, WebAssembly, FMPy, plain Python, structured text, and in float32.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from device_bodies import SANITIZERS, fmu_differences, run_c, run_python, run_wasm, st_differences, write_files
from device_designs import random_design

from observer_lab.devices import DeviceError
from observer_lab.export.devices.folders import device_design, device_files
from observer_lab.lessons import LESSONS

BODIES = ("gcc -O0", "gcc -O3", "sanitizers", "wasm", "FMPy", "Python", "ST", "float")
SAME = "every bit as in the lab's Python."


def tried(lesson, outcome, folder: Path, bodies: tuple[str, ...] = BODIES, part: str | None = None) -> dict[str, bool]:
    """Whether a design, or a part of it alone, gives the same bits, by body."""
    design, files = device_design(lesson, outcome, part=part), partial(device_files, lesson, outcome, "token", part=part)
    write_files(folder, files("c"))
    found = {}
    for body in bodies:
        if body in ("gcc -O0", "gcc -O3"):
            found[body] = run_c(folder, [body.split()[1]]).endswith(SAME)
        elif body == "sanitizers":
            found[body] = run_c(folder, SANITIZERS).endswith(SAME)
        elif body == "wasm":
            found[body] = run_wasm(folder).endswith(SAME)
        elif body == "Python":
            found[body] = run_python(write_files(folder / "python", files("micropython"))).endswith(SAME)
        elif body == "ST":
            try:
                block = str(files("st")["FB_Lab.st"])
            except DeviceError:  # a filter with functions of its own, as sine; it is said to the person
                continue
            found[body] = st_differences(block, design) == 0
        elif body == "FMPy":
            unit = write_files(folder / "fmu", files("fmu")) / "lab.fmu"
            found[body] = fmu_differences(unit, design) == 0
        elif body == "float":
            single = write_files(folder / "float", files("c", single=True))
            found[body] = run_c(single, ["-O3"]).endswith(SAME)
    return found


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--designs", type=int, default=20)
    options = parser.parse_args()
    wrong = 0
    print(f"{'lesson':<20}{'designs':>8}{'refused':>8}  " + "".join(f"{body:>12}" for body in BODIES))
    rows = [(name, lesson, part) for name, lesson in LESSONS.items() for part in (None, *lesson.device_parts)]
    for name, lesson, part in rows:
        if options.lessons and name not in options.lessons:
            continue
        random, done, refused = np.random.default_rng(50), 0, 0
        differ: dict[str, int | None] = dict.fromkeys(BODIES)  # None where a body has run nothing
        while done < options.designs and refused < 5 * options.designs:
            outcome = random_design(lesson, random, device_design)
            if outcome is None:
                refused += 1
                continue
            done += 1
            with tempfile.TemporaryDirectory() as folder:
                for body, same in tried(lesson, outcome, Path(folder), part=part).items():
                    differ[body] = (differ[body] or 0) + (not same)
        wrong += sum(count or 0 for count in differ.values())
        counts = "".join(f"{'–' if count is None else count:>12}" for count in differ.values())
        print(f"{f'{name} {part}' if part else name:<20}{done:>8}{refused:>8}  {counts}", flush=True)
    return int(wrong > 0)


if __name__ == "__main__":
    raise SystemExit(main())
