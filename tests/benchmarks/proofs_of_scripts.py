"""By hand: every lesson's exported code at its default and at random designs, each run in a process that knows nothing of us.

`python tests/benchmarks/proofs_of_scripts.py [--designs N] [--plants] [--to matlab] [LESSON …]` prints a line
a lesson and the sum. MATLAB's files run in Octave, a notebook cell by cell; that on the engine alone knows this house.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from observer_lab.course.knobs import Choice, Knob, KnobError, Number, Poles, Switch
from observer_lab.course.lesson import Design, Lesson
from observer_lab.engine import EngineError
from observer_lab.export.files import SCRIPTS
from observer_lab.export.scripts.script import ScriptError
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import EXAMPLES, example

HOUSE = Path(__file__).resolve().parents[2]
RUNNER = """
import json, runpy, sys, traceback, warnings
warnings.simplefilter('ignore')
from matplotlib import pyplot as plt
for name in sys.argv[1:]:
    try:
        if name.endswith('.ipynb'):
            with open(name, encoding='utf-8') as file:
                cells = json.load(file)['cells']
            space = {}
            for cell in cells:
                if cell['cell_type'] == 'code':
                    exec(compile(cell['source'], name, 'exec'), space)
        else:
            runpy.run_path(name)
        print('RIGHT', name)
    except BaseException as problem:
        last = traceback.extract_tb(problem.__traceback__)[-1]
        print('WRONG', name, type(problem).__name__, str(problem)[:200].replace(chr(10), ' '), last.lineno, last.line)
    plt.close('all')
"""


def some(knob: Knob, rng: random.Random) -> object:
    """A value of a knob that a person may turn to."""
    share = rng.random()
    if isinstance(knob, Number):
        if knob.scale == "integer":
            return float(rng.randint(int(knob.low), int(knob.high)))
        return knob.low * (knob.high / knob.low) ** share if knob.scale == "log" else knob.low + share * (knob.high - knob.low)
    if isinstance(knob, Choice):
        return rng.choice([value for value, _ in knob.options])
    if isinstance(knob, Switch):
        return share < 0.5
    return tuple((0.6 + share) * pole for pole in knob.default) if isinstance(knob, Poles) else knob.default


def designs(lesson: Lesson, count: int) -> Iterator[Design]:
    """The start, and `count` random designs, the same every time; half of their knobs are turned."""
    yield lesson.start()
    rng = random.Random(lesson.id + lesson.plant)
    while count:
        changes = {knob.name: some(knob, rng) for knob in lesson.knobs if rng.random() < 0.5}
        try:
            yield lesson.apply(lesson.start(), changes)
            count -= 1
        except (EngineError, KnobError):
            continue


OCTAVE = """
for k = 0:{last}
    name = sprintf('script_%d', k);
    try
        feval(name, false);
        printf('RIGHT %s\\n', name);
    catch problem
        printf('WRONG %s %s\\n', name, strrep(problem.message, sprintf('\\n'), ' '));
    end
end
"""


def scripts(lesson: Lesson, count: int, language: str, spoken: str = "en") -> Iterator[tuple[Design, str]]:
    """Every design that can be computed, with its script."""
    for design in designs(lesson, count):
        try:
            outcome = lesson.compute(design)
        except (EngineError, KnobError):
            continue
        try:
            yield design, SCRIPTS[language][0](lesson, outcome, "1.x", spoken)
        except ScriptError as problem:
            print(f"    {problem}")
        except (EngineError, KnobError):  # what refuses when it is looked at
            continue


def judged(texts: list[str], folder: Path, language: str) -> list[str]:
    """What a clean process says of each script."""
    names = [f"script_{k}.{SCRIPTS[language][1].split('.')[-1]}" for k in range(len(texts))]
    for name, text in zip(names, texts, strict=True):
        (folder / name).write_text(text, encoding="utf-8")
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"MPLBACKEND": "agg"}
    alone = "-I"
    if language == "engine-notebook":
        alone, env["PYTHONPATH"] = "-P", str(HOUSE)
    command = ([sys.executable, alone, "-c", RUNNER, *names] if language != "matlab" else
               ["octave-cli", "--quiet", "--no-init-file", "--eval", OCTAVE.replace("{last}", str(len(names) - 1))])
    done = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True)
    said = [line for line in done.stdout.splitlines() if line.startswith(("RIGHT", "WRONG"))]
    return said if len(said) == len(names) else [*said, f"WRONG {done.stderr[-500:]}"]


def lessons(names: list[str], plants: bool) -> Iterator[tuple[str, Lesson]]:
    """The lessons asked for, and those of them that take a person's plant with every example."""
    for id in names or LESSONS:
        yield id, LESSONS[id]
        for name in EXAMPLES if plants and LESSONS[id].adapt is not None else ():
            try:
                yield f"{id} on {name}", LESSONS[id].fit(example(name))
            except (EngineError, KnobError):
                continue


def main() -> int:
    """Run all and print what came out."""
    parser = argparse.ArgumentParser()
    parser.add_argument("lessons", nargs="*")
    parser.add_argument("--designs", type=int, default=3)
    parser.add_argument("--plants", action="store_true", help="the example plants too")
    parser.add_argument("--to", default="python", choices=tuple(SCRIPTS))
    parser.add_argument("--lang", default="en", help="of the comments")
    parser.add_argument("--keep", help="a folder for the scripts")
    options = parser.parse_args()
    right = wrong = 0
    for name, lesson in lessons(options.lessons, options.plants):
        started = time.perf_counter()
        all_of = list(scripts(lesson, options.designs, options.to, options.lang))
        if not all_of:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(options.keep or scratch)
            folder.mkdir(parents=True, exist_ok=True)
            found = judged([text for _, text in all_of], folder, options.to)
        bad = [(line, design) for line, (design, _) in zip(found, all_of, strict=False) if not line.startswith("RIGHT")]
        right, wrong = right + len(found) - len(bad), wrong + len(bad)
        print(f"{name:24} {len(found) - len(bad)} of {len(found)} prove themselves, {time.perf_counter() - started:.1f} s", flush=True)
        for line, design in bad:
            print("   ", line, dict(design.values))
    print(f"{right} scripts prove themselves, {wrong} do not.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
