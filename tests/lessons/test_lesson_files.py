"""Lessons as TOML and Markdown: what they compute, what is refused with file and line, and what a changed file does to open tabs."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from client import WireTab, eventually
from commands import refused as refused_command
from fakes import Clock, FakeView
from laws import each
from scipy.linalg import expm
from served import Served

from observer_lab.cli.entry import main
from observer_lab.cli.lesson_folder import follow_folder
from observer_lab.course.lesson import Lesson
from observer_lab.course.reading.toml_table import LessonFileError, lines_of
from observer_lab.lessons.from_files.folder import LessonFolder
from observer_lab.lessons.from_files.read_lesson import read_lesson
from observer_lab.page.screen.server import LabServer
from observer_lab.session.commands.commands import SetKnobs
from observer_lab.session.commands.files import LessonsChanged
from observer_lab.session.session import Session

GUIDE = (Path(__file__).parents[2] / "assets" / "lessons" / "README.md").read_text(encoding="utf-8")
FIRST, _, SECOND = GUIDE.partition("## A nonlinear plant")
LINES = {kind: re.findall(rf"```{kind}\n(.*?)```", FIRST, re.DOTALL) for kind in ("sh", "toml", "markdown")}
NONLINEAR = {kind: re.findall(rf"```{kind}\n(.*?)```", SECOND, re.DOTALL) for kind in ("sh", "toml", "python")}
COMMANDS = [line.split()[1:] for block in (*LINES["sh"], *NONLINEAR["sh"]) for line in block.splitlines()]


def written(place: Path, command: list[str]) -> Path:
    """The folder of a lesson that a command of the guide writes."""
    home = place / command[command.index("--folder") + 1]
    assert main([*command[:-1], str(home)]) == 0
    return home / command[1]


@pytest.fixture
def first(tmp_path: Path) -> Path:
    """The first lesson of the guide, as its first command writes it."""
    return written(tmp_path, COMMANDS[0])


@pytest.fixture
def whole(first: Path) -> Path:
    """The first lesson with all that the guide adds."""
    for name, blocks in (("lesson.toml", LINES["toml"]), ("lesson.md", LINES["markdown"])):
        (first / name).write_text("\n".join([(first / name).read_text(encoding="utf-8"), *blocks]), encoding="utf-8")
    return first


@pytest.fixture
def nonlinear(tmp_path: Path) -> Path:
    """The nonlinear lesson of the guide."""
    place = written(tmp_path, COMMANDS[2])
    (place / "lesson.toml").write_text(NONLINEAR["toml"][0], encoding="utf-8")
    (place / "tank.py").write_text(NONLINEAR["python"][0], encoding="utf-8")
    return place


def changed(path: Path, old: str, new: str) -> None:
    """Save a file with a text in place of another, at a time of its own."""
    words = path.read_text(encoding="utf-8")
    assert old in words
    path.write_text(words.replace(old, new), encoding="utf-8")
    os.utime(path, ns=(path.stat().st_atime_ns, path.stat().st_mtime_ns + 1_000_000))


@contextmanager
def with_change(path: Path, old: str, new: str) -> Iterator[None]:
    """A file with a text in place of another, for a while."""
    words = path.read_text(encoding="utf-8")
    changed(path, old, new)
    yield
    path.write_text(words, encoding="utf-8")


# --- the guide -----------------------------------------------------------------------------------------------------
def test_the_guide_has_the_commands_that_are_followed() -> None:
    assert [command[0] for command in COMMANDS] == ["new-lesson", "serve", "new-lesson", "serve"]
    assert COMMANDS[1] == ["serve", "--lessons", COMMANDS[0][-1]] and COMMANDS[3] == [*COMMANDS[1], "--trust-code"]


def test_every_step_of_the_guide_leaves_a_lesson_that_is_read(first: Path) -> None:
    """A task or a scene waits for its words, which the guide adds next."""
    toml, markdown = first / "lesson.toml", first / "lesson.md"
    assert read_lesson(first, 22, False).draft
    for block in LINES["markdown"]:
        markdown.write_text(f"{markdown.read_text(encoding='utf-8')}\n{block}", encoding="utf-8")
    for block in LINES["toml"]:
        toml.write_text(f"{toml.read_text(encoding='utf-8')}\n{block}", encoding="utf-8")
        read_lesson(first, 22, False)
    lesson = read_lesson(first, 22, False)
    assert [knob.name for knob in lesson.knobs if not knob.hidden] == ["q", "first", "k"]
    assert [figure.id for figure in lesson.figures(lesson.compute(lesson.start()))] == ["error", "state-velocity"]
    assert ([task.id for task in lesson.tasks], [scene.id for scene in lesson.path]) == (["settle"], ["meet", "guess", "stiffer"])
    assert [exam.id for exam in lesson.exams] == ["gain", "spring"] and len(lesson.words["en"].derivation) == 1


def test_the_error_of_the_guide_is_named_with_file_and_line(whole: Path) -> None:
    (wrong, right), = re.findall(r"Write `(.*?)` for `(.*?)`", GUIDE)
    changed(whole / "lesson.toml", right, wrong)
    line = (whole / "lesson.toml").read_text(encoding="utf-8").splitlines().index(wrong) + 1
    assert refused(whole) == f"lesson.toml, line {line}: There is no key kin here; use kind, of, title, id."


# --- what it computes ----------------------------------------------------------------------------------------------
def test_the_error_follows_the_matrix_exponential(first: Path) -> None:
    lesson = read_lesson(first, 22, False)
    outcome = lesson.compute(lesson.apply(lesson.start(), {"first": 0.5, "q": (-2.0, -2.5)}))
    A, C = np.array([[0, 1], [-1, -0.5]]), np.array([[1, 0]])
    run = outcome.run
    assert run is not None
    assert np.allclose(run.e[100], expm((A - outcome.gains["L"] @ C) * run.t[100]) @ [0.5, 0.0], atol=1e-9)
    assert np.allclose(np.sort(np.linalg.eigvals(A - outcome.gains["L"] @ C)), [-2.5, -2.0])


def test_the_observer_assumes_the_parameters_of_the_model(whole: Path) -> None:
    lesson = read_lesson(whole, 22, False)
    true, wrong = (lesson.compute(lesson.apply(lesson.start(), {"k": k})) for k in (1.0, 2.0))
    assert np.array_equal(true.gains["L"], wrong.gains["L"])
    assert wrong.run is not None and wrong.run.scenario.plant.A[1, 0] == -2.0 and wrong.run.scenario.model.A[1, 0] == -1.0


def test_every_knob_moves_a_figure_and_the_task_is_solved_by_its_solution_alone(whole: Path) -> None:
    lesson = read_lesson(whole, 22, False)
    start = lesson.start()

    def drawn(**values: object) -> list[np.ndarray]:
        return [curve.y for figure in lesson.figures(lesson.compute(lesson.apply(start, values))) for curve in figure.curves]
    before = drawn()
    for values in ({"q": (-2.0, -2.5)}, {"first": 1.5}, {"k": 2.0}):
        assert not all(map(np.array_equal, before, drawn(**values))), values
    task = lesson.tasks[0]
    assert [task.judge(lesson.compute(lesson.apply(start, v))).solved for v in ({}, task.solution, {**task.solution, "k": 1.5})] == [
        False, True, False]


def test_a_nonlinear_plant_runs_by_its_own_equations(nonlinear: Path) -> None:
    """The level of a tank that empties: with u = hole it tends to 1 m, and √x obeys its own differential equation."""
    lesson = read_lesson(nonlinear, 22, True)
    outcome = lesson.compute(lesson.start())
    run = outcome.study.run
    assert outcome.run is None, "no script of a linear loop"
    rate = np.gradient(run.x[:, 0], run.t)[5:-5]
    assert np.allclose(rate, 0.5 - 0.5 * np.sqrt(run.x[5:-5, 0]), atol=1e-4)
    assert abs(run.e[-1, 0]) < 1e-3 < abs(run.e[0, 0]) and np.allclose(outcome.poles["observer"], [-2.0], atol=1e-6)


@each("plant, extra", [
    ('named = "two-mass"', ""), ('named = "deck"', ""), ('named = "cart-pendulum"', "[controller]\nQ = 1.0\nR = 0.1\n"),
    ('file = "plant.json"', "")])
def test_plants_by_name_and_by_file(first: Path, plant: str, extra: str) -> None:
    from observer_lab.plants.examples import example

    (first / "plant.json").write_text(example("tanks"), encoding="utf-8")
    (first / "lesson.toml").write_text(
        f"answer = 2\n[plant]\n{plant}\n[observer]\nW = 1.0\nV = 0.01\n{extra}[[figures]]\nkind = \"poles\"\n", encoding="utf-8")
    lesson = read_lesson(first, 22, False)
    outcome = lesson.compute(lesson.start())
    assert outcome.metrics["slowest_observer"] < 0 and outcome.stage is not None and ("controller" in outcome.poles) == bool(extra)


def test_a_knob_moves_a_parameter_of_a_named_plant(first: Path) -> None:
    (first / "lesson.toml").write_text('answer = 2\n[plant]\nnamed = "spring-damper"\n[[knobs]]\nname = "k"\nlow = 0.5\nhigh = 2\n'
                                       '[observer]\npoles = [-1, "-1+1j", "-1-1j"]\n', encoding="utf-8")
    assert "line 9: This plant has 2 states and needs as many poles; there are 3" in refused(first)
    changed(first / "lesson.toml", "-1, ", "")
    lesson = read_lesson(first, 22, False)
    run = lesson.compute(lesson.apply(lesson.start(), {"k": 2.0})).run
    assert run is not None and run.scenario.plant.A[1, 0] == -2.0 and lesson.start()["k"] == 1.0


# --- what is refused -----------------------------------------------------------------------------------------------
def refused(place: Path, trusted: bool = False) -> str:
    """The one sentence by which a lesson is refused, said in Chinese too."""
    with pytest.raises(LessonFileError) as problem:
        read_lesson(place, 22, trusted)
    said = problem.value.text("en")
    assert "\n" not in said and len(said) < 400 and re.match(r"[\w.-]+, line \d+: ", said), said
    return said


WRONG = (
    ("m = 1.0", "m = ", "This is no valid TOML"),
    ("m = 1.0", 'm = "heavy"', "m must be a number; it is heavy."),
    ("b = 0.5", '"b b" = 0.5', "b b cannot name a parameter"),
    ('"-k/m", "-b/m"', '"-k/m"', "The rows of A must be equally long."),
    ('["1/m"]]', '["1/m"], [0]]', "B must"),
    ('"-b/m"', '"-c/m"', "The formula -c/m of A has no value; it may use m, b, k, first."),
    ('"-b/m"', "false", "A must hold numbers or formulas in quotes; it holds False."),
    ('low = -2.0', "low = 3.0", "The range of first is reversed: 3 is above 2."),
    ("default = 0.0", "default = 5.0", "choose a value within"),
    ('label = "guessed position"', 'lable = "guess"', "There is no key lable here; use name, kind,"),
    ('kind = "poles"', 'kind = "pole"', "kind cannot be pole; use one of number, poles."),
    ("[-1.0, -1.5]", '["-1+1j", -1.5]', "complex poles must come in conjugate pairs."),
    ('poles = "q"', 'poles = "p"', "there is no such knob p."),
    ("step = 0.03", "step = 0", "step must lie between 0 and seconds"),
    ("step = 0.03", "step = 0.0001", "120000 steps are too many"),
    ("start = [1.0, 0.0]", "start = [1.0]", "start must have 2 entries; it has 1."),
    ('kind = "error"', 'kind = "errors"', "kind cannot be errors; use one of state, output,"),
    ('of = "velocity"', 'of = "speed"', "of cannot be speed; use one of position, velocity."),
    ("settled = [0, 2.5]", "settled = [2.5, 0]", "The range of settled is reversed: 2.5 is above 0."),
    ("settled = [0, 2.5]", "settled = 2.5", "settled must be a range of two numbers, [low, high]; it is 2.5."),
    ("settled = [0, 2.5]", "setled = [0, 2.5]", "There is no key setled here; use settled,"),
    ("settled = [0, 2.5]", "settled = [0, 20]", "The task settle is solved at the start already; narrow its ranges."),
    ("solution = { q = [-3, -3] }", "solution = { q = [-1, -3] }", "The solution of the task settle does not solve it:"),
    ("solution = { q = [-3, -3] }", "solution = { g = 1 }", "There is no knob g; there are q, first, k."),
    ("keep = { k = 1.0 }", "keep = { k = 7.0 }", "choose a value within"),
    ('id = "settle"', 'id = "settled"', "lesson.md has no section “## task settled: title”."),
    ('id = "meet"', 'id = "met"', "lesson.md has no section “## scene met: title”."),
    ('do = "predict"', 'do = "guess"', "do cannot be guess; use one of read, predict,"),
    ('knobs = ["k"]', 'knobs = ["z"]', "knobs names z, which does not exist; there are q, first, k."),
    ('knobs = ["k"]', "", "A scene that asks to move a knob must name it in knobs or in move."),
    ('knobs = ["k"]', 'move = ["z"]', "move names z, which does not exist; there are q, first, k"),
    ('knobs = ["k"]', 'knobs = ["k"]\ngoal = { way = "up" }', "way cannot be up; use one of"),
    ('knobs = ["k"]', 'knobs = ["k"]\ngoal = { value = 7 }', "choose a value within"),
    ('knobs = ["k"]', 'knobs = ["k"]\ntask = "settle"', 'Only a scene with do = "solve" may have task; this one has do = "move".'),
    ('do = "predict"', 'do = "again"', "This scene asks the second prediction, and the lesson has no table [again]."),
    ('do = "predict"', 'do = "choose"\nanswer = 1', "answer names the right option, and the words list no options."),
    ('do = "predict"', 'formulas = ["M"]', "formulas names M, which does not exist; there are L."),
    ('do = "predict"', 'boards = ["controller"]', "boards names controller, which does not exist; there are observer."),
    ('do = "predict"', 'camera = "moon"', "camera cannot be moon; use one of"),
    ("draft = true", "key = ['z']", "key names z, which does not exist;"),
    ("[model]\nk = 1.0", "[again]\nanswer = 1", "lesson.md has no section “## again”."),
    ('figures = ["state-velocity"]', 'figures = ["velocity"]', "figures names velocity, which does not exist; there are error,"),
    ("answer = 2", "answer = 4", "answer must be the number of the right option, 1 to 3; it is 4."),
    ("answer = 2", "anwser = 2", "There is no key anwser here; use draft, minutes, answer,"),
    ("draft = true", 'draft = "yes"', "draft must be true or false; it is yes."),
    ("[model]\nk = 1.0", "[model]\nkk = 1.0", "There is no parameter kk; there are m, b, k, first."),
    ('inputs = ["force"]', 'inputs = ["<b>force"]', "The name <b>force must be short and plain"),
    ("units = {", "unit = {", "There is no key unit here; use A, B, C, D,"),
    ("[plant]", '[plant]\nnamed = "chip"', "[plant] needs exactly one of A (with B and C), file, named and python."),
)


@each("old, new, said", WRONG)
def test_a_wrong_file_is_one_sentence_with_the_line_that_is_wrong(whole: Path, old: str, new: str, said: str) -> None:
    path = whole / "lesson.toml"
    with with_change(path, old, new):
        words, found = path.read_text(encoding="utf-8"), refused(whole)
    assert said in found
    line = int(found.partition("line ")[2].partition(":")[0])
    at = words[:words.index(new) + len(new)].count("\n") + 1 if new else line
    assert abs(line - at) <= 1, f"{found} (changed in line {at})"


@each("old, new, said", [("# Leaky", "Leaky", "must begin with '# title'"), ("### reveal", "### shown", "has no reveal"),
                         ("## predict", "## guess", "has a section '## guess'")])
def test_wrong_words_are_one_sentence(first: Path, old: str, new: str, said: str) -> None:
    with with_change(first / "lesson.md", old, new):
        assert said in refused(first)


def test_code_runs_only_where_it_is_trusted(nonlinear: Path, tmp_path: Path) -> None:
    (nonlinear / "tank.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w').close()\n", encoding="utf-8")
    assert "tank.py is Python code and is not run; start the server with --trust-code if you trust it." in refused(nonlinear)
    assert not (tmp_path / "ran").exists()
    assert refused(nonlinear, trusted=True) == "tank.py, line 1: The file has no function f(x, u, p)."
    assert (tmp_path / "ran").exists()


@each("old, new, said", [("return [x[0]]", "return x / nothing", "tank.py, line 11: NameError"),
                         ("def h", "def h(", "tank.py, line 9: SyntaxError"),
                         ("return [x[0]]", "return [x[0], 1]", "h must return 1 number; it returns 2."),
                         ("from math", "exit()\nfrom math", "tank.py, line 1: SystemExit")])
def test_wrong_code_is_one_sentence_with_its_line(nonlinear: Path, old: str, new: str, said: str) -> None:
    with with_change(nonlinear / "tank.py", old, new):
        assert said in refused(nonlinear, trusted=True)


def test_files_beside_the_lesson_are_read_and_no_others(first: Path) -> None:
    for kind, what in (("file", "plant file"), ("python", "Python file")):
        (first / "lesson.toml").write_text(f'answer = 2\n[plant]\n{kind} = "../secret"\nstates = ["x"]\noutputs = ["y"]\n'
                                           if kind == "python" else f'answer = 2\n[plant]\n{kind} = "../secret"\n', encoding="utf-8")
        assert f"There is no {what} secret beside this lesson." in refused(first, trusted=True)


def test_lines_are_found_in_tables_lists_and_over_several_lines() -> None:
    found = lines_of('a = 1\n[b]\nc = [\n  [1],\n  # d = 2\n]\nd = "[" # x\n[[e]]\nf = 1\n[[e]]\nf = 2\n[e.g]\nh = 1\n')
    wanted = {("a",): 1, ("b",): 2, ("b", "c"): 3, ("b", "d"): 7, ("e", 0, "f"): 9, ("e", 1, "f"): 11, ("e", 1, "g", "h"): 13}
    assert {place: found.get(place) for place in wanted} == wanted


# --- folders and tabs ----------------------------------------------------------------------------------------------
def test_a_folder_reads_again_what_has_changed_and_nothing_else(whole: Path, nonlinear: Path) -> None:
    folder = LessonFolder(whole.parent, ("separation",), True)
    before = folder.lessons()
    assert list(before) == ["leaky-tank", "tank-level"] and [lesson.number for lesson in before.values()] == [2, 3]
    assert not folder.changed()
    changed(whole / "lesson.toml", 'label = "stiffness"', 'label = "spring"')
    assert folder.changed()
    after = folder.lessons()
    assert after["tank-level"] is before["tank-level"] and after["leaky-tank"].knob("k").label("en") == "spring"


def test_a_folder_with_the_name_of_a_lesson_is_shown_as_broken(whole: Path) -> None:
    whole.rename(whole.parent / "separation")
    (id, lesson), = LessonFolder(whole.parent, ("separation",), False).lessons().items()
    assert id == "separation-broken" and "There is a lesson of this name already" in lesson.fault("en")


class Tab:
    """A session on the lessons of a folder, step by step."""

    def __init__(self, place: Path) -> None:
        self.folder = LessonFolder(place.parent, (), False)
        self.clock, self.view = Clock(), FakeView()
        self.session = Session(self.folder.lessons(), self.view, place.name, clock=self.clock)
        self.session.open()

    def reload(self) -> None:
        """Look at the files, as the server does."""
        assert self.folder.changed()
        self.session.post(LessonsChanged(self.folder.lessons()))
        self.session.step()

    @property
    def lesson(self) -> Lesson:
        assert self.session.picture is not None
        return self.session.picture.lesson


def test_a_changed_lesson_is_shown_anew_with_the_knobs_where_they_were(whole: Path) -> None:
    tab = Tab(whole)
    tab.session.post(SetKnobs({"first": 0.5}))
    tab.session.step()
    changed(whole / "lesson.toml", 'label = "stiffness"', 'label = "spring"')
    tab.reload()
    assert tab.lesson.knob("k").label("en") == "spring"
    assert tab.session.picture is not None and tab.session.picture.design["first"] == 0.5


def test_a_broken_lesson_leaves_an_open_tab_its_last_good_picture(whole: Path) -> None:
    tab = Tab(whole)
    before = tab.lesson
    changed(whole / "lesson.toml", 'kind = "state"', 'kin = "state"')
    tab.reload()
    assert tab.lesson is before and ["There is no key kin" in said("en") for said in tab.view.scolded()] == [True]
    tab.session.post(SetKnobs({"first": 0.5}))
    tab.session.step()
    assert tab.session.picture is not None and tab.session.picture.design["first"] == 0.5
    changed(whole / "lesson.toml", 'kin = "state"', 'kind = "state"')
    tab.reload()
    assert tab.lesson is not before and not tab.lesson.fault.id


@pytest.fixture
def served(whole: Path) -> Iterator[tuple[Path, LabServer]]:
    """A server that follows the folder."""
    folder = LessonFolder(whole.parent, (), False)
    server = LabServer(folder.lessons(), port=0, lesson=whole.name)
    ended: list[bool] = []
    follow_folder(folder, server.replace_lessons, lambda: bool(ended))
    yield whole, server
    ended.append(True)
    server.stop()


@pytest.mark.slow
def test_a_served_lesson_opens_reloads_on_save_and_a_new_page_shows_what_is_wrong(served: tuple[Path, LabServer]) -> None:
    place, server = served
    with WireTab(server.url) as tab:
        tab.settle()
        changed(place / "lesson.toml", 'label = "stiffness"', 'label = "spring"')
        tab.until(lambda: tab.has("spring [N/\N{WORD JOINER}m]"), "the changed knob")
        changed(place / "lesson.toml", 'kind = "state"', 'kin = "state"')
        tab.until(lambda: any("There is no key kin here" in note for note in tab.notes), "what is wrong")
        assert tab.has("spring [N/\N{WORD JOINER}m]"), "the last good picture stays"
        eventually(lambda: server._lessons[place.name].fault.id, "the broken lesson")
        with WireTab(server.url) as other:
            other.settle()
            assert any("There is no key kin here" in str(w["props"]) for w in other.widgets.values())
        changed(place / "lesson.toml", 'kin = "state"', 'kind = "state"')
        tab.until(lambda: not server._lessons[place.name].fault.id, "the mended lesson")


@pytest.mark.slow
@each("command, fault", [(COMMANDS[1], "tank.py is Python code and is not run"), (COMMANDS[3], "")])
def test_the_commands_of_the_guide_serve_its_lessons(whole: Path, nonlinear: Path, command: list[str], fault: str) -> None:
    with Served([sys.executable, "-m", "observer_lab", *command, "--port", "0", "--view", "lab", "--lesson", nonlinear.name],
                cwd=whole.parent.parent, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=dict(os.environ)) as server:
        assert server.stdout is not None and server.stderr is not None
        with WireTab(server.stdout.readline().strip()) as tab:
            tab.settle()
            assert tab.has("size of the hole") is not bool(fault)
            assert any("tank.py is Python code" in str(w["props"]) for w in tab.widgets.values()) is bool(fault)
        server.send_signal(signal.SIGTERM)
        assert server.wait(60) == 0
        said = server.stderr.read()
        assert ("lesson tank-level" in said) is bool(fault) and fault in said and "lesson leaky-tank" not in said


def test_a_folder_without_lessons_is_refused_in_one_sentence(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert "There is no folder" in refused_command(capsys, "serve", "--lessons", str(tmp_path / "nowhere"))
    assert "holds no lesson" in refused_command(capsys, "serve", "--lessons", str(tmp_path))
