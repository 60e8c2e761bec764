"""An exported script runs in a clean process and passes its own assertions; what cannot be written is one sentence."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.cli.entry import main
from app.export.script import ScriptError, parts_of, python_script
from app.lesson.lesson import Design, Lesson
from app.plants.examples import example
from app.tab.state import Saved
from app.tab.token import write_token
from lessons import LESSONS

LATE = {"delay": 18.0, "limited": True, "u_max": 0.5, "noise": 2.0, "seed": 3.0, "kick": 1.003}
# Each a way of its own along the grid: exact, clipped with delay, noise, kick and a wrong model, sampled.
DESIGNS = (("noise", "", {}), ("separation", "", {**LATE, "stiffness_error": 10.0}),
           ("sandbox", "pendulum", {"noisy": True, "limited": True}))


def design_of(id: str, plant: str, changes: dict[str, object]) -> tuple[Lesson, Design]:
    lesson = LESSONS[id].fit(example(plant)) if plant else LESSONS[id]
    return lesson, lesson.apply(lesson.start(), changes)


def run_alone(script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A script in a process that knows nothing of us."""
    (folder / "script.py").write_text(script, encoding="utf-8")
    env = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"} | {"MPLBACKEND": "agg"}
    return subprocess.run([sys.executable, "-I", "script.py"], cwd=folder, env=env, capture_output=True, text=True)


@pytest.mark.slow
@pytest.mark.parametrize("id, plant, changes", DESIGNS, ids=[id for id, _, _ in DESIGNS])
def test_a_script_proves_itself_in_a_clean_process(id: str, plant: str, changes: dict[str, object], tmp_path: Path) -> None:
    lesson, design = design_of(id, plant, changes)
    script = python_script(lesson, lesson.compute(design), write_token(LESSONS[id], Saved(design)))
    assert "app" not in {line.split()[1].split(".")[0] for line in script.splitlines() if line.startswith(("import ", "from "))}
    done = run_alone(script, tmp_path)
    assert done.returncode == 0 and "agree to 1e-06" in done.stdout, done.stderr[-2000:]


@pytest.mark.slow
def test_a_script_whose_numbers_are_not_the_pages_fails(tmp_path: Path) -> None:
    lesson, design = design_of("noise", "", {})
    script = python_script(lesson, lesson.compute(design), "1.x")
    assert "seed = 1\n" in script
    done = run_alone(script.replace("seed = 1\n", "seed = 2\n"), tmp_path)
    assert done.returncode == 1 and "AssertionError" in done.stderr


def test_a_lesson_whose_run_is_of_another_kind_says_so() -> None:
    lesson = LESSONS["network"]
    with pytest.raises(ScriptError, match="no script is written"):
        list(parts_of(lesson, lesson.compute(lesson.start()), "1.x"))


def test_export_writes_code_a_notebook_and_data(capsys, tmp_path: Path) -> None:
    for kind, suffix in (("python", "py"), ("notebook", "ipynb"), ("json", "json"), ("csv", "csv")):
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


def test_what_cannot_be_exported_is_status_2(capsys, tmp_path: Path) -> None:
    assert main(["export", "network", "--to", "python", "-o", str(tmp_path / "x.py")]) == 2
    assert "no script is written" in capsys.readouterr().err and not (tmp_path / "x.py").exists()
    assert main(["export", "noise", "--to", "pdf", "-o", str(tmp_path / "x.txt")]) == 2
