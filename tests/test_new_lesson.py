"""A new lesson: the guide in CONTRIBUTING works by its own commands, and a wrong name or place is one sentence."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from client import WireTab
from commands import refused
from served import Served

ROOT = Path(__file__).parents[1]
GUIDE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## A new lesson")[2].partition("\n## ")[0]
COMMANDS = tuple(line.split() for line in re.findall(r"```sh\n(.*?)```", GUIDE, re.DOTALL)[0].splitlines())
NAME, FILES = COMMANDS[0][2], {"__init__.py", "lesson.py", "lesson.toml", "knobs.py", "study.py", "figures.py", "tasks.py", "en.md"}


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the package, in which the guide may write."""
    place = tmp_path_factory.mktemp("site")
    without = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "app", place / "observer_lab", ignore=without)
    shutil.copytree(ROOT / "lessons", place / "observer_lab" / "lessons", ignore=without)
    return place


def begun(copy: Path, words: list[str]) -> Served:
    """A command of the guide, started on the copy."""
    assert words[0] == "observer-lab"
    return Served([sys.executable, "-m", "observer_lab", *words[1:]], cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                  text=True, env={**os.environ, "PYTHONPATH": str(copy)})


@pytest.fixture(scope="module")
def printed(copy: Path) -> Iterator[list[str]]:
    """What the commands of the guide print, up to the one that serves."""
    found = []
    for words in COMMANDS[:-1]:
        with begun(copy, words) as process:
            out, err = process.communicate(timeout=300)
            assert (process.returncode, err) == (0, ""), words
            found.append(out)
    yield found


def test_the_guide_has_the_commands_that_are_followed() -> None:
    assert [words[1] for words in COMMANDS] == ["new-lesson", "run", "serve"]


@pytest.mark.slow
def test_the_first_command_writes_the_standard_files_and_names_the_folder(printed: list[str], copy: Path) -> None:
    folder = copy / "observer_lab" / "lessons" / NAME.replace("-", "_")
    assert printed[0].splitlines() == [str(folder), f"open it with: {' '.join(COMMANDS[-1])}"]
    assert {path.name for path in folder.iterdir()} - {"__pycache__"} == FILES
    assert not [path.name for path in folder.glob("*.*") if re.search(r"@\w+@", path.read_text(encoding="utf-8"))]
    assert "guess = 0.5 m" in printed[1] and "largest_gain" in printed[1]


@pytest.mark.slow
def test_the_draft_opens_in_the_page_and_its_card_says_that_it_is_one(printed: list[str], copy: Path) -> None:
    with begun(copy, [*COMMANDS[-1], "--port", "0"]) as server:
        assert server.stdout is not None
        with WireTab(server.stdout.readline().strip()) as tab:
            tab.settle()
            assert tab.value("guessed position [m]") == 0.0
            tab.update("guessed position [m]", value=0.5)
            tab.settle()
            assert tab.value("guessed position [m]") == 0.5 and not tab.notes
            assert {"/board/observer", "/board/observer/pole0"} <= set(tab.nodes)
            tab.command("All lessons")
            tab.until(lambda: any("<small>draft</small>" in str(w["props"].get("content")) for w in tab.widgets.values()), "the card")
        server.send_signal(signal.SIGTERM)
        assert server.wait(60) == 0


@pytest.mark.slow
def test_the_draft_obeys_the_laws_of_knobs_figures_and_tasks(printed: list[str], copy: Path) -> None:
    """Every knob moves the figure, the task fails at the start and passes at its solution."""
    with Served([sys.executable, "-c", LAWS, NAME], cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                env={**os.environ, "PYTHONPATH": str(copy)}) as process:
        assert process.communicate(timeout=300)[0].split() == ["0", "True", "True", "False", "True"]


LAWS = """
import sys
import numpy as np
from observer_lab.lessons import LESSONS, all_lessons
lesson = all_lessons()[sys.argv[1]]
start = lesson.start()
drawn = lambda **values: lesson.figures(lesson.compute(lesson.apply(start, values)))[0].curves[0].y
print(sum(each.draft for each in LESSONS.values()))
for values in ({"observer_poles": (-2.0, -2.5)}, {"guess": 0.5}):
    print(not np.array_equal(drawn(), drawn(**values)))
task = lesson.tasks[0]
for values in ({}, task.solution):
    print(task.judge(lesson.compute(lesson.apply(start, values))).solved)
"""


def test_a_name_that_is_taken_or_none_is_refused_in_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "There is a lesson kalman already" in refused(capsys, "new-lesson", "kalman", "--folder", str(tmp_path))
    for name in ("Tank", "leaky_tank", "../tank", "tank-", "t" * 40):
        assert "cannot name a lesson" in refused(capsys, "new-lesson", name, "--folder", str(tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_hold_the_lesson_is_refused_in_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert "cannot be written" in refused(capsys, "new-lesson", "tank", "--folder", str(tmp_path / "file" / "below"))
    (tmp_path / "tank").mkdir()
    assert "exists already" in refused(capsys, "new-lesson", "tank", "--folder", str(tmp_path))
