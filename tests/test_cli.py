"""The command line: the contract of its output and exit status, and one sentence for every kind of bad input."""

import json
import re
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest
from commands import refused

from observer_lab import lessons
from observer_lab.cli import inputs
from observer_lab.cli.commands import serve as serving
from observer_lab.cli.commands.serve import ServeRequest
from observer_lab.cli.entry import main
from observer_lab.course.exercises.exam import seed_of
from observer_lab.course.lesson import Check, Job, Lesson
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.published import records
from observer_lab.session.state.saved_state import SavedState, write_state
from observer_lab.session.state.token import read_token, write_token
from observer_lab.text import same

SEPARATION = LESSONS["separation"]
ROOT = Path(__file__).parents[1]


def run_json(capsys, *words: str) -> tuple[int, dict]:
    status = main(["run", "separation", "--json", *words])
    out, err = capsys.readouterr()
    assert err == ""
    return status, json.loads(out)


def use(monkeypatch, lesson: Lesson) -> None:
    for module in (inputs, lessons):
        monkeypatch.setattr(module, "all_lessons", lambda: MappingProxyType({lesson.id: lesson}))


def test_run_prints_the_contracts_record_at_the_lessons_start(capsys) -> None:
    status, record = run_json(capsys)
    outcome = SEPARATION.compute(SEPARATION.start())
    assert list(record) == ["lesson", "knobs", "gains", "poles", "metrics", "never", "checks", "series", "sentences"]
    assert record["lesson"] == "separation" and list(record["knobs"]) == [k.name for k in SEPARATION.knobs]
    assert np.array_equal(record["gains"]["K"], outcome.gains["K"])
    loop = [complex(*pair) for pair in record["poles"]["loop"]]
    assert loop == outcome.poles["loop"].tolist() and len(loop) == 12
    assert record["metrics"] == dict(outcome.metrics)
    assert [check["id"] for check in record["checks"]] == [check.id for check in outcome.checks]
    assert np.array_equal(record["series"]["x"], outcome.run.x) and np.array_equal(record["series"]["t"], outcome.run.t)
    assert status == (0 if all(check.holds for check in outcome.checks) else 1)


@pytest.mark.parametrize("lesson", LESSONS)
def test_every_lesson_runs_in_words_and_as_strict_json(lesson: str, capsys) -> None:
    assert main(["run", lesson]) in (0, 1)
    words = capsys.readouterr().out
    for knob in LESSONS[lesson].knobs:
        assert f"  {knob.name} = " in words
    assert main(["run", lesson, "--json"]) in (0, 1)
    json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


def test_set_reaches_the_design_and_the_last_one_wins(capsys) -> None:
    _, record = run_json(capsys, "--set", "delay=30", "--set", "limited=on", "--set", "delay=12",
                         "--set", "controller_poles=-4,-5,-6+7j,-6-7j,-3+2j,-3-2j")
    assert record["knobs"]["delay"] == 12.0 and record["knobs"]["limited"] is True
    reached = np.sort_complex([complex(*p) for p in record["poles"]["controller"]])
    assert np.abs(reached - np.sort_complex([-4, -5, -6 + 7j, -6 - 7j, -3 + 2j, -3 - 2j])).max() < 1e-6


def test_a_saved_design_comes_back_and_set_comes_after_it(capsys, tmp_path: Path) -> None:
    design = SEPARATION.apply(SEPARATION.start(), {"delay": 18.0, "u_max": 0.5, "limited": True})
    file = tmp_path / "state.json"
    file.write_text(write_state(SEPARATION, SavedState(design)), encoding="utf-8")
    _, record = run_json(capsys, "--set", "u_max=0.7", "--state", str(file))
    assert (record["knobs"]["delay"], record["knobs"]["u_max"], record["knobs"]["limited"]) == (18.0, 0.7, True)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_figure_and_csv_are_written(suffix: str, capsys, tmp_path: Path) -> None:
    figure, table = tmp_path / f"page.{suffix}", tmp_path / "data.csv"
    main(["run", "separation", "--figure", str(figure), "--csv", str(table)])
    assert figure.stat().st_size > 5000
    told, _, *rows = table.read_text(encoding="utf-8").splitlines()
    token = told.rpartition(" ")[2]
    assert read_token(token, LESSONS).design == SEPARATION.start() and any(",t [s]," in row for row in rows)
    assert suffix == "pdf" or token.encode() in figure.read_bytes(), "the token stands in the figure's file"
    names = {line.split(",")[0] for line in rows}
    assert names == {f.id for f in SEPARATION.figures(SEPARATION.compute(SEPARATION.start()))}


@pytest.mark.slow
def test_a_state_brings_its_language_and_camera_to_every_file(capsys, tmp_path: Path) -> None:
    camera = (0.0, -9.0, 3.0, 0.0, 0.5, 1.0)
    token = write_token(SEPARATION, SavedState(SEPARATION.start(), "zh", camera=camera))
    page, script, figure = (str(tmp_path / name) for name in ("run.html", "run.py", "run.svg"))
    assert main(["replay", "separation", "--state", token, "-o", page]) == 0
    assert main(["export", "separation", "--state", token, "--to", "python", "-o", script]) == 0
    assert main(["run", "separation", "--state", token, "--figure", figure]) == 0
    capsys.readouterr()
    assert main(["link", "separation", "--state", token]) == 0
    assert capsys.readouterr().out.strip().endswith(f"#{token}")
    words = SEPARATION.words["zh"]
    assert words.question in Path(page).read_text(encoding="utf-8") and token in Path(page).read_text(encoding="utf-8")
    assert words.title in Path(script).read_text(encoding="utf-8") and token in Path(figure).read_text(encoding="utf-8")
    assert main(["export", "separation", "--state", token, "--lang", "en", "--to", "python", "-o", script]) == 0
    assert words.title not in Path(script).read_text(encoding="utf-8")


def test_a_file_that_cannot_be_finished_leaves_the_one_before_it(capsys, tmp_path: Path, monkeypatch) -> None:
    def breaks_off(figures: object, path: str, token: str) -> None:
        Path(path).write_text("figure,kind")
        raise OSError(28, "No space left on device")
    table = tmp_path / "data.csv"
    main(["run", "separation", "--csv", str(table)])
    whole = table.read_bytes()
    capsys.readouterr()
    monkeypatch.setattr("observer_lab.export.data.data.save_csv", breaks_off)
    assert "no space left" in refused(capsys, "run", "separation", "--csv", str(table))
    assert table.read_bytes() == whole and list(tmp_path.iterdir()) == [table]


def test_a_check_that_fails_is_status_1(capsys, monkeypatch) -> None:
    def with_check(holds: bool) -> Lesson:
        return replace(SEPARATION,
                       compute=lambda d: replace(SEPARATION.compute(d), checks=(Check("c", same("c"), holds),)))
    use(monkeypatch, with_check(True))
    assert main(["run", "separation"]) == 0
    use(monkeypatch, with_check(False))
    assert main(["run", "separation"]) == 1
    assert "FAILS  c" in capsys.readouterr().out


def test_the_long_computation_runs_only_with_final(capsys, monkeypatch) -> None:
    def job(outcome):
        yield 0.5, replace(outcome, metrics={**outcome.metrics, "half": 1.0})
        yield 1.0, replace(outcome, metrics={**outcome.metrics, "done": 1.0})
    use(monkeypatch, replace(SEPARATION, job=Job(same("long"), job, key=lambda design: design, shown=lambda outcome, found: found)))
    assert "done" not in run_json(capsys)[1]["metrics"]
    metrics = run_json(capsys, "--final")[1]["metrics"]
    assert metrics["done"] == 1.0 and "half" not in metrics
    use(monkeypatch, replace(SEPARATION, job=None))
    assert "union_error" in run_json(capsys, "--final")[1]["metrics"]


def test_a_design_that_the_engine_refuses_is_bad_input(capsys, monkeypatch) -> None:
    def never(design):
        raise EngineError("No gain reaches these poles.")
    use(monkeypatch, replace(SEPARATION, compute=never))
    assert "No gain reaches these poles" in refused(capsys, "run", "separation")


@pytest.mark.parametrize(("words", "told"), [
    (["frob"], "no command frob"),
    (["run"], "LESSON"),
    (["run", "nope"], "no lesson nope"),
    (["run", "separation", "--plant", "x.json"], "x.json cannot be read"),
    (["run", "separation", "--js"], "--js"),
    (["run", "separation", "--set", "delay"], "no equals sign"),
    (["run", "separation", "--set", "foo=1"], "no knob foo"),
    (["run", "separation", "--set", "delay=fast"], "must be a number"),
    (["run", "separation", "--set", "delay=NaN"], "finite"),
    (["run", "separation", "--set", "delay=inf"], "finite"),
    (["run", "separation", "--set", "delay=1e9"], "0 … 60 ms"),
    (["run", "separation", "--set", "delay="], "must be a number"),
    (["run", "separation", "--set", "limited=maybe"], "on or off"),
    (["run", "separation", "--set", "observer_poles=-1,-2"], "exactly 6 poles, not 2"),
    (["run", "separation", "--set", "observer_poles=-9,-9,-9,-9,-9,nan"], "within"),
    (["run", "separation", "--set", "observer_poles=-9,-9,-9,-9,-9,-8+1j"], "conjugate pairs"),
    (["run", "separation", "--state", "no-such-file.json"], "cannot be read"),
    (["run", "separation", "--state", "."], "cannot be read"),
    (["run", "separation", "--state", "a\0b"], "cannot be read"),
    (["run", "separation", "--state", "/dev/zero"], "no plain file"),
    (["run", "separation", "--plant", "/dev/zero"], "no plain file"),
    (["run", "separation", "--plant", "a\0b.json"], "cannot be read"),
    (["run", "separation", "--figure", "no-such-folder/x.png"], "cannot be written"),
    (["run", "separation", "--figure", "x.gif"], ".png, .svg, .pdf"),
    (["run", "separation", "--csv", "no-such-folder/x.csv"], "cannot be written"),
    (["list", "extra"], "extra"),
    (["teach"], "LESSON"),
    (["teach", "nope"], "no lesson nope"),
    (["teach", "kalman", "--lang", "de"], "de"),
    (["exam", "kalman"], "--key"),
    (["exam", "nope", "--key", "me"], "no lesson nope"),
    (["exam", "kalman", "--key", "me", "--variant", "-1"], "no variant"),
    (["status", "127.0.0.1:8080"], "is no address"),
    (["serve", "--data-dir", "a\0b"], "cannot hold what is kept"),
    (["--port", "abc"], "not a port"),
    (["serve", "--port", "65536"], "not a port"),
    (["serve", "--port", "٣"], "not a port"),
    (["--lang", "de"], "de"),
    (["--lesson", "nope"], "no lesson nope"),
    (["serve", "--max-sessions", "0"], "tabs"),
    (["serve", "--host", "203.0.113.9", "--public"], "cannot listen"),
    (["serve", "--host", "no.such.host.invalid"], "cannot listen"),
    (["serve", "--host", "a" * 70 + ".example"], "cannot listen"),
    (["serve", "--host", "203.0.113.9"], "say --public"),
    (["serve", "--host", "0.0.0.0"], "say --public"),
    (["serve", "--host", "::"], "say --public"),
    (["serve", "--allow-host", "http://lab.example"], "without http"),
    (["serve", "--allow-host", "lab.example:port"], "not the name of a host"),
])
def test_bad_input_is_status_2_and_one_sentence(words: list[str], told: str, capsys, tmp_path: Path,
                                                monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert told in refused(capsys, *words)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("text", "told"), [
    (b"", "not a design"),
    (b"\xff\xfe\x00", "not text"),
    (b"{", "not a design"),
    (b"[1, 2]", "not a design"),
    (b'{"version": 1, "lesson": "separation", "knobs": 3}', "not a design"),
    (b'{"version": 99, "lesson": "separation", "knobs": {}}', "version 99"),
    (b'{"version": 1, "lesson": "nope", "knobs": {}}', "no lesson nope"),
    (b'{"version": 1, "lesson": "separation", "knobs": {"delay": NaN}}', "finite"),
    (b'{"version": 1, "lesson": "separation", "knobs": {"delay": 1' + b"0" * 400 + b"}}", "finite"),
    (b'{"version": 1, "lesson": "separation", "knobs": {"delay": [[[]]]}}', "must be a number"),
    (b"[" * 100_000, "not a design"),
])
def test_a_broken_state_file_is_status_2_and_one_sentence(text: bytes, told: str, capsys, tmp_path: Path) -> None:
    file = tmp_path / "state.json"
    file.write_bytes(text)
    assert told in refused(capsys, "run", "separation", "--state", str(file))


def test_the_state_of_another_lesson_is_refused(capsys, tmp_path: Path) -> None:
    other = next(lesson for lesson in LESSONS.values() if lesson.id != "separation")
    file = tmp_path / "state.json"
    file.write_text(write_state(other, SavedState(other.start())), encoding="utf-8")
    assert f"belongs to lesson {other.id}" in refused(capsys, "run", "separation", "--state", str(file))


def test_list_names_every_lesson_knob_and_task(capsys) -> None:
    assert main(["list"]) == 0
    words = capsys.readouterr().out
    assert main(["list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [entry["id"] for entry in listed] == list(LESSONS)
    for entry, lesson in zip(listed, LESSONS.values(), strict=True):
        assert f". {lesson.id}: " in words
        assert [knob["name"] for knob in entry["knobs"]] == [knob.name for knob in lesson.knobs]
        assert [task["id"] for task in entry["tasks"]] == [task.id for task in lesson.tasks]
        assert all(f"--set {knob.name}=" in words for knob in lesson.knobs)
        assert all(f"task {task.id}: " in words for task in lesson.tasks)
        assert entry["title"]["en"] and entry["title"]["zh"]
        assert entry["needs"] == list(lesson.place.needs) and all(way.title("en") in words for way in lesson.place.ways)


def test_every_default_that_list_shows_is_read_back_by_set(capsys) -> None:
    main(["list"])
    shown = re.findall(r"--set (\w+)=(.*?)    ", capsys.readouterr().out)
    names = [(lesson, knob) for lesson in LESSONS.values() for knob in lesson.knobs]
    assert len(shown) == len(names)
    for (name, words), (_, knob) in zip(shown, names, strict=True):
        assert name == knob.name
        if words or not isinstance(knob.check(knob.default), tuple):
            assert np.allclose(knob.parse(words), knob.check(knob.default), rtol=1e-5) if isinstance(
                knob.check(knob.default), (tuple, float)) else knob.parse(words) == knob.check(knob.default)


@pytest.mark.slow
def test_verify_prints_every_value_and_is_status_1_when_one_differs(capsys, monkeypatch) -> None:
    """Here a few of them, one of each verdict and some more; `test_published.py` and the wheel's own command verify all."""
    every = records()
    some = (*every[:12], *(next(p for p in every if p.kind == kind) for kind in ("slip", "beyond")))
    monkeypatch.setattr("observer_lab.published.records", lambda: some)
    assert main(["verify"]) == 0
    words = capsys.readouterr().out
    assert all(published.item in words for published in some)
    assert main(["verify", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [entry["item"] for entry in listed] == [published.item for published in some]
    assert {entry["verdict"] for entry in listed} == {"agrees", "slip", "beyond"}
    wrong = replace(every[0], ours=lambda: 3.0)
    monkeypatch.setattr("observer_lab.published.records", lambda: (wrong,))
    assert main(["verify"]) == 1
    assert "DIFFERS" in capsys.readouterr().out


def test_teach_prints_the_notes_as_they_are_written_and_then_the_terms(capsys) -> None:
    for words, path in ((["hidden-modes"], "lessons/hidden_modes/teacher.md"),
                        (["hidden-modes", "--lang", "zh"], "app/locale/zh/hidden-modes.teacher.md")):
        assert main(["teach", *words]) == 0
        notes = (ROOT / path).read_text(encoding="utf-8")
        told = capsys.readouterr().out
        assert told.startswith(f"{notes}## ") and told.count("## ") == notes.count("## ") + 1


def test_exam_prints_what_a_key_draws_and_the_answers(capsys) -> None:
    lesson = LESSONS["kalman"]
    for lang, variant in (("en", 0), ("zh", 3)):
        assert main(["exam", "kalman", "--key", "Li Wei", "--variant", str(variant), "--lang", lang]) == 0
        told = capsys.readouterr().out
        assert "[[" not in told and told.count("## ") == len(lesson.exams)
        for exam in lesson.exams:
            right = exam.digits.written(exam.item(seed_of("li wei", "kalman", exam.id, variant)).answer)
            assert f"## {lesson.words[lang].exams[exam.id].title}\n" in told and f"\n**{right}**\n" in told


def test_help_is_status_0_and_names_the_commands(capsys) -> None:
    with pytest.raises(SystemExit) as leaving:
        main(["--help"])
    assert leaving.value.code == 0
    told = capsys.readouterr().out
    assert all(command in told for command in ("serve", "list", "teach", "run", "verify"))


def test_without_a_command_serve_is_meant(monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(serving, "serve", lambda request: asked.append(request) or 0)
    assert main([]) == 0 and main(["--port", "8123", "--lang", "zh"]) == 0
    assert main(["serve", "--host", "0.0.0.0", "--public", "--lesson", "separation", "--max-sessions", "7",
                 "--allow-host", "lab.example:8443", "--allow-host", "::1"]) == 0
    assert asked == [ServeRequest(), ServeRequest(port=8123, language="zh"),
                     ServeRequest("0.0.0.0", 8080, "separation", "en", 7, None, ("lab.example:8443", "::1"), True)]


def test_a_link_holds_what_was_set_and_run_takes_it_back(capsys, tmp_path: Path) -> None:
    link, code, state = "https://lab.example/o/", tmp_path / "q.svg", tmp_path / "state.json"
    assert main(["link", "separation", "--set", "delay=18", "--lang", "zh", "--at", link, "--qr", str(code), "-o", str(state)]) == 0
    printed = capsys.readouterr().out.strip()
    assert printed.startswith(f"{link}#1.") and len(printed) < 100 and "<svg" in code.read_text()
    for words in (printed, printed.rpartition("#")[2], str(state)):
        assert run_json(capsys, "--state", words)[1]["knobs"]["delay"] == 18.0
    assert "neither" in refused(capsys, "link", "separation", "--qr", str(tmp_path / "q.gif"))


def test_a_state_with_something_unknown_runs_with_a_note(capsys, tmp_path: Path) -> None:
    file = tmp_path / "state.json"
    file.write_text('{"version": 1, "lesson": "separation", "knobs": {"delay": 18, "foo": 1}, "bar": 2}')
    assert main(["run", "separation", "--json", "--state", str(file)]) in (0, 1)
    out, err = capsys.readouterr()
    assert json.loads(out)["knobs"]["delay"] == 18.0 and "foo" in err and "bar" in err


def test_serve_takes_a_state_or_a_lesson_with_its_plant(capsys) -> None:
    assert "a state brings its own" in refused(capsys, "serve", "--state", "1.AAAA", "--lesson", "noise")
    assert "torn" in refused(capsys, "serve", "--state", "1.AAAA")


@pytest.mark.parametrize("command", [["run"], ["replay"], ["export", "--to", "python"], ["export", "--to", "json"]], ids=" ".join)
def test_knobs_that_cross_are_refused_in_one_sentence(
        command: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([command[0], "decoupling", *command[1:], "--set", "f_low=4", "--set", "f_high=0.5"]) == 2
    assert not list(tmp_path.iterdir())
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "must reach from 4 Hz to at least 6 Hz" in said


def test_a_plant_without_dynamics_and_with_unseen_modes_gives_no_traceback(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "still.json"
    path.write_text('{"A": [[0,0],[0,0]], "B": [[1],[2]], "C": [[1,0]]}')
    assert main(["run", "separation", "--plant", str(path)]) in (0, 1)
    assert "Traceback" not in capsys.readouterr().err


def test_a_scene_is_not_linked_into_the_lab_and_a_lesson_without_exams_says_so(capsys, monkeypatch) -> None:
    assert main(["link", "kalman", "--view", "lab", "--scene", "predict"]) == 2
    assert "--view guide or present" in capsys.readouterr().err
    use(monkeypatch, replace(SEPARATION, exams=(), path=()))
    assert main(["exam", "separation", "--key", "anna"]) == 2 and "has no exams" in capsys.readouterr().err
    assert main(["link", "separation", "--scene", "meet"]) == 2 and "no path of scenes" in capsys.readouterr().err
