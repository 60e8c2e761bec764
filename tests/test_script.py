"""An exported script runs in a clean process and passes its own assertions; what cannot be written is one sentence."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import matplotlib
import pytest
from benchmarks.proofs_of_scripts import designs
from matplotlib import pyplot as plt

from observer_lab.cli.entry import main
from observer_lab.course.lesson import Design, Lesson
from observer_lab.export.scripts.engine_notebook import engine_notebook
from observer_lab.export.scripts.matlab import function_name, matlab_script
from observer_lab.export.scripts.script import ScriptError, parts_of, python_script
from observer_lab.lessons import LESSONS
from observer_lab.plants.examples import example
from observer_lab.plants.own_plant import clean_plant_json
from observer_lab.session.state.saved_state import SavedState
from observer_lab.session.state.token import write_token

LATE = {"delay": 18.0, "limited": True, "u_max": 0.5, "noise": 2.0, "seed": 3.0, "kick": 1.003}
# Each a way of its own along the grid: exact, clipped with delay, noise, kick and a wrong model, sampled.
DESIGNS = (("noise", "", {}), ("separation", "", {**LATE, "stiffness_error": 10.0}),
           ("separation", "", {"pull": [(0.3, 0.6), (0.7, -1.2), (0.9, 0.0)]}), ("saturation", "", {"pull_2": [(0.1, 1.0), (0.4, 0.0)]}),
           ("sandbox", "pendulum", {"noisy": True, "limited": True}),
           ("weak-states", "tanks", {"order": 2}), ("weak-states", "aircraft", {}),
           # Weights so far apart that SciPy's solver of Riccati's equation gives up.
           ("lqg", "", {"case": "platform", "beta_q": 0.0042, "beta_r": 0.0043, "recovery": 8.0757}))


ONE_AFTER_ANOTHER = """
import runpy, sys
from matplotlib import pyplot as plt
for k in range(int(sys.argv[1])):
    try:
        runpy.run_path(f"{k}.py")
        print("@")
    except Exception as problem:
        print("@" + type(problem).__name__, str(problem).replace(chr(10), " "))
    plt.close("all")
"""


def sampled(turn: int) -> list[tuple[Lesson, Design]]:
    """DESIGNS, and of every lesson its start or one of three random designs, another at another turn."""
    every = [(lesson, list(designs(lesson, 3))[(k + turn) % 4]) for k, lesson in enumerate(LESSONS.values())]
    return [*(design_of(*one) for one in DESIGNS), of_two_inputs(), *every]


def of_two_inputs() -> tuple[Lesson, Design]:
    """A bilinear plant whose first input is random and whose second one was drawn by hand."""
    plant = {"A": [[-1, 0.4, 0], [0.2, -2, 0.5], [0, 0.7, -3]], "B": [[1, 0], [0, 1], [1, 1]], "C": [[1, 0, 0], [0, 1, 0]],
             "K": [[0, 0, 1]], "F1": [[0.1, 0, 0.3], [0, 0.2, 0.1], [0, 0, -0.2]], "F2": [[0, 0.2, 0], [0, 0, 0.1], [0.3, 0, 0]]}
    lesson = LESSONS["bilinear-observer"].fit(clean_plant_json(json.dumps(plant)))
    return lesson, lesson.apply(lesson.start(), {"input": "random", "input2": "hand", "hand2": ((0.3, 0.2), (1.0, -0.1)), "noise": 1.0})


def design_of(id: str, plant: str, changes: Mapping[str, object]) -> tuple[Lesson, Design]:
    lesson = LESSONS[id].fit(example(plant)) if plant else LESSONS[id]
    return lesson, lesson.apply(lesson.start(), changes)


def run_alone(scripts: list[str], folder: Path) -> list[str]:
    """What a process that knows nothing of us says of each script: nothing where it runs to its end."""
    for k, script in enumerate(scripts):
        (folder / f"{k}.py").write_text(script, encoding="utf-8")
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"MPLBACKEND": "agg"}
    done = subprocess.run([sys.executable, "-I", "-c", ONE_AFTER_ANOTHER, str(len(scripts))], cwd=folder, env=env, capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return [line.removeprefix("@") for line in done.stdout.splitlines() if line.startswith("@")]


@pytest.mark.slow
def test_scripts_prove_themselves_in_a_clean_process_and_fail_where_a_number_is_not_the_pages(tmp_path: Path) -> None:
    wanted = sampled(0)
    scripts = [python_script(lesson, lesson.compute(design), write_token(LESSONS[lesson.id], SavedState(design)), ("en", "zh")[k % 2])
               for k, (lesson, design) in enumerate(wanted)]
    for script in scripts:
        assert "app" not in {line.split()[1].split(".")[0] for line in script.splitlines() if line.startswith(("import ", "from "))}
        assert "print('Observer Lab: " in script
    said = run_alone([*scripts, scripts[0].replace("seed = 1\n", "seed = 2\n")], tmp_path)
    assert not [(lesson.id, design.values, words) for (lesson, design), words in zip(wanted, said, strict=False) if words]
    assert len(said) == len(wanted) + 1 and said[-1].startswith("AssertionError")


@pytest.mark.slow
def test_matlab_files_are_whole_functions_and_prove_themselves_where_octave_is_found(tmp_path: Path) -> None:
    wanted = sampled(1)
    for k, (lesson, design) in enumerate(wanted):
        text = matlab_script(lesson, lesson.compute(design), "1.x", ("zh", "en")[k % 2])
        assert text.startswith(f"function {function_name(lesson)}(draw)\n") and "None" not in text and " nan" not in text
        code = [line.split("%")[0].strip().rstrip(";") for line in text.splitlines()]
        opened = sum(line.split(" ")[0].split("(")[0] in ("function", "if", "for", "while", "switch", "try") for line in code)
        assert opened == code.count("end") and text.count("(") == text.count(")") and text.count("[") == text.count("]")
        (tmp_path / f"design_{k}.m").write_text(text, encoding="utf-8")
    if octave := shutil.which("octave-cli"):
        calls = "; ".join(f"design_{k}(false)" for k in range(len(wanted)))
        done = subprocess.run([octave, "--quiet", "--no-init-file", "--eval", calls], cwd=tmp_path, capture_output=True, text=True)
        assert done.stdout.count("agree to 1e-06") == len(wanted), done.stderr[-2000:]


@pytest.mark.slow
def test_the_notebook_on_the_engine_leads_in_ten_lines_to_the_pages_run() -> None:
    for id, plant, changes in (*DESIGNS, ("kalman", "", {}), ("lqg", "tanks", {}), ("observability", "", {})):
        lesson, design = design_of(id, plant, changes)
        outcome = lesson.compute(design)
        for language in ("en", "zh"):
            cells = json.loads(engine_notebook(lesson, outcome, "1.x", language))["cells"]
            given, ten, proof = (cell["source"] for cell in cells if cell["cell_type"] == "code")
            assert len(ten.splitlines()) == 10
        with matplotlib.rc_context({"backend": "agg"}):
            exec(compile("\n".join((given, ten, proof)), "notebook", "exec"), space := {})
        assert space["run"].x.shape == (len(space["run"].t), space["plant"].n)
        plt.close("all")
    lesson, design = design_of("nonlinear", "", {"case": "fall"})
    with pytest.raises(ScriptError, match="not linear"):
        engine_notebook(lesson, lesson.compute(design), "1.x")


def test_a_lesson_whose_run_is_of_another_kind_says_so() -> None:
    lesson = LESSONS["separation"]
    with pytest.raises(ScriptError, match="No script is written"):
        list(parts_of(lesson, replace(lesson.compute(lesson.start()), run=None), "1.x"))


def test_export_writes_code_a_notebook_and_data(capsys, tmp_path: Path) -> None:
    for kind, suffix in (
            ("matlab", "m"), ("python", "py"), ("notebook", "ipynb"), ("engine-notebook", "engine.ipynb"), ("json", "json"),
            ("csv", "csv")):
        file = tmp_path / f"x.{suffix}"
        assert main(["export", "noise", "--to", kind, "--set", "seed=5", "-o", str(file)]) == 0
        assert capsys.readouterr().out.strip() == str(file)
    cells = json.loads((tmp_path / "x.ipynb").read_text())["cells"]
    code = "\n\n".join(cell["source"] for cell in cells if cell["cell_type"] == "code")
    compile(code, "notebook", "exec")
    body = [line for line in (tmp_path / "x.py").read_text().splitlines() if line and not line.startswith("# %%")]
    assert [line for line in code.splitlines() if line] == body
    record = json.loads((tmp_path / "x.json").read_text())
    assert record["knobs"]["seed"] == 5 and main(["run", "noise", "--json", "--state", record["token"]]) in (0, 1)
    assert json.loads(capsys.readouterr().out)["series"] == record["series"]


def test_what_cannot_be_exported_is_status_2(tmp_path: Path) -> None:
    assert main(["export", "noise", "--to", "pdf", "-o", str(tmp_path / "x.txt")]) == 2
