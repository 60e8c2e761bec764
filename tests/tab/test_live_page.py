"""A page beside a running plant: what is drawn, recorded and sent, and that nothing is sent once the page is gone."""

import time
from dataclasses import replace
from functools import reduce
from operator import xor
from pathlib import Path

import numpy as np
import pytest
from fakes import Clock, FakeView
from laws import each
from live_endurance import replayed

from observer_lab.cli import main
from observer_lab.devices import watching
from observer_lab.devices.sampling import DeviceError
from observer_lab.engine.systems import discretise
from observer_lab.export.devices.c_project import simulator_files
from observer_lab.export.devices.folders import device_design
from observer_lab.export.devices.words import column_names
from observer_lab.lessons import LESSONS
from observer_lab.live.desk import LiveDesk
from observer_lab.live.drive import PAGE_GONE_S, Drive, feedback_of, input_line
from observer_lab.live.lesson import live_lesson
from observer_lab.live.lines import LineReader
from observer_lab.live.observer import RESET_LINES, LiveObserver
from observer_lab.live.rows import measured_states
from observer_lab.live.simulated import simulated
from observer_lab.page.record.recorded_screen import Look, RecordedScreen
from observer_lab.page.words import phrases
from observer_lab.session.commands.commands import PageSeen, Play, Seek, SetKnobs
from observer_lab.session.commands.files import LinesCame
from observer_lab.session.session import Session


def desk_for(name: str, folder: Path, clock: Clock, drive: Drive | None = None):
    lesson = LESSONS[name]
    design = device_design(lesson, lesson.compute(lesson.start()))
    names = [column.partition(":") for column in column_names(design.routine)[1:]]
    reader = LineReader(tuple(n for kind, _, n in names if kind == "u"), tuple(n for kind, _, n in names if kind == "y"))
    desk = LiveDesk(design.routine, lesson.start(), lambda outcome: device_design(lesson, outcome).routine, reader, clock, folder, drive)
    return lesson, design, desk


def line(design, k: int, t: float | None = None) -> bytes:
    at = k * design.routine.period if t is None else t
    return (",".join(repr(float(v)) for v in (at, *design.u[k], *design.y[k])) + "\n").encode()


def feed(desk: LiveDesk, data: bytes) -> bytes:
    answer = b""
    for sample in desk.reader.feed(data):
        _, answer = desk.take(sample)
    return answer


@each("name", ["noise", "separation", "kalman"])
def test_record_replayed_by_the_compiled_step_gives_every_bit_of_the_page(name: str, tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp(name)
    _, design, desk = desk_for(name, folder, Clock())
    desk.toggle_record()
    lost = {7, 8, 31, 90}
    shown = []
    for k in range(120):
        if k not in lost:
            for sample in desk.reader.feed(line(design, k)):
                shown.append(desk.take(sample)[0].xhat)
    desk.toggle_record()
    rows = np.loadtxt(folder / "live-1.csv", delimiter=",", skiprows=1, ndmin=2)
    assert len(rows) == 116 and np.array_equal(replayed(folder, design.routine, rows), np.array(shown))


def test_record_of_the_page_is_what_the_lesson_record_reads(tmp_path, capsys) -> None:
    _, design, desk = desk_for("noise", tmp_path, Clock())
    random = np.random.default_rng(4)
    exciting = replace(design, u=random.choice([-1.0, 1.0], (300, 1)), y=0.01 * random.normal(size=(300, 1)).cumsum(axis=0))
    desk.toggle_record()
    for k in range(300):
        feed(desk, line(exciting, k))
    desk.toggle_record()
    head, *rows = (tmp_path / "live-1.csv").read_text().splitlines()
    assert len(rows) == 300
    columns = "t=t u={1} y={2}".format(*head.split(","))
    assert main(["run", "record", "--data", str(tmp_path / "live-1.csv"), "--columns", columns, "--json"]) in (0, 1)
    capsys.readouterr()


def test_record_begun_in_the_middle_of_a_run_holds_what_came_from_then_on_and_is_read(tmp_path, capsys) -> None:
    """Its first time is not 0, lines are lost in it, others late; a second record of the same run is a file of its own."""
    _, design, desk = desk_for("noise", tmp_path, Clock())
    random = np.random.default_rng(5)
    u = random.choice([-1.0, 1.0], (800, 1))
    exciting = replace(design, u=u, y=0.01 * u.cumsum(axis=0) + 1e-3 * random.normal(size=(800, 1)))
    T, late = design.routine.period, np.where(random.random(800) < 0.05, 0.2 * random.random(800), 0.0)
    times = [3600.0 + (k + late[k]) * T for k in range(800)]
    for k in range(700):
        if k in (250, 620):
            desk.toggle_record()
        if k not in {300, 301, 455, 630}:
            feed(desk, line(exciting, k, times[k]))
        if k in (599, 699):
            desk.toggle_record()
    for file, kept in (("live-1.csv", sorted({*range(250, 600)} - {300, 301, 455})), ("live-2.csv", sorted({*range(620, 700)} - {630}))):
        rows = np.loadtxt(tmp_path / file, delimiter=",", skiprows=1)
        assert np.array_equal(rows[:, 0], [times[k] for k in kept]) and np.array_equal(rows[:, 2], exciting.y[kept, 0])
    columns = "t=t u={1} y={2}".format(*(tmp_path / "live-1.csv").read_text().splitlines()[0].split(","))
    assert main(["run", "record", "--data", str(tmp_path / "live-1.csv"), "--columns", columns, "--json"]) in (0, 1)
    assert '"data": "own"' in capsys.readouterr().out


def test_body_stands_where_the_readings_are_and_the_ghost_where_the_estimate_is(tmp_path) -> None:
    lesson, design, desk = desk_for("separation", tmp_path, Clock())
    for k in range(50):
        feed(desk, line(design, k))
    outcome, figures = desk.shown(1, lesson.compute(lesson.start()))
    C = lesson.compute(lesson.start()).run.scenario.plant.C
    assert np.allclose(outcome.stage.x @ C.T, design.y[:50], atol=1e-12)
    assert np.allclose(outcome.stage.xhat, design.expected()["xhat"][:50], rtol=0, atol=1e-12)
    reading = next(figure for figure in figures if figure.id == "reading0")
    assert np.array_equal(reading.curves[0].y[-50:], design.y[:50, 0]) and reading.x[-1] == 0


def test_missing_reading_leaves_the_body_at_the_estimate() -> None:
    _, design, _ = desk_for("noise", Path(), Clock())
    xhat = np.array([[1.0, 2.0]])
    assert np.array_equal(measured_states(watching(design.routine), xhat, np.array([[np.nan]]), np.zeros((1, 1))), xhat)


def test_knob_of_the_page_changes_the_observer_that_runs_and_a_new_tab_does_not(tmp_path) -> None:
    lesson, design, desk = desk_for("separation", tmp_path, Clock())
    view, done = FakeView(), []
    session = Session({"separation": live_lesson(lesson, lesson.start(), desk)}, view, "separation", clock=Clock())
    session.open()
    before = desk.observer.routine
    for k in range(30):
        feed(desk, line(design, k))
    session.post(LinesCame(1, lambda: done.append(1)))
    session.step()
    assert done == [1] and desk.observer.routine is before and view.of("show")[-1].outcome.stage.t[-1] > 0
    session.post(SetKnobs({"stiffness_error": 20.0}))
    session.post(LinesCame(1, lambda: done.append(2)))
    session.step()
    assert done == [1, 2] and desk.observer.routine is not before
    desk.shown(2, lesson.compute(lesson.start()))
    assert any("Another tab" in words("en") for words in desk.said(2)) and not any("Another tab" in words("en") for words in desk.said(1))


def test_ghost_alone_moves_with_a_line_between_two_pictures(tmp_path) -> None:
    """On the page's own screen: parts of body and ghost stand where the last line puts them, and nothing else has changed."""
    lesson, design, desk = desk_for("noise", tmp_path, Clock())
    screen = RecordedScreen(Look("en"))
    session = Session({"noise": live_lesson(lesson, lesson.start(), desk)}, screen, "noise", clock=Clock())
    session.open()
    for k in range(30):
        feed(desk, line(design, k))
    session.post(LinesCame(1, lambda: None))
    session.step()
    before, shown, pictures = dict(screen.values), session.picture, desk.number(1)
    feed(desk, line(design, 30))
    done = []
    session.post(LinesCame(1, lambda: done.append(1), whole=False))
    session.step()
    changed = {place for place, value in screen.values.items() if not np.array_equal(before.get(place), value)}
    body, xhat = shown.outcome.stage.body, design.expected()["xhat"][30]
    pose = body.pose([*xhat, *shown.outcome.stage.x[0, len(xhat):]], body.gain)
    moved = [part.name for part in body.parts if part.twin and (f"scene:/ghost/{part.name}", "@SetPositionMessage") in changed]
    assert moved and done == [1] and session.picture is shown and desk.number(1) == pictures
    stands = {name: screen.values[f"scene:/ghost/{name}", "@SetPositionMessage"]["position"] for name in moved}
    assert all(np.allclose(place, pose[name].position, rtol=0, atol=1e-9) for name, place in stands.items())
    nodes = {f"scene:/{root}/{part.name}" for root in ("ghost", "plant") for part in body.parts}
    ghost = [*xhat, *shown.outcome.stage.x[0, len(xhat):]]
    words = {f"scene:/error-words/{k}" for k, _ in enumerate(body.marks(ghost, ghost, body.gain).words)}
    assert {name for name, _ in changed} <= nodes | words | {"scene:/errors", "scene:/forces", "scene:/error-bars"}
    stage = desk.stage(shown.outcome)
    assert np.array_equal(stage.x[-1, -stage.readings:], [design.y[k, 0] for k in range(30, 18, -1)])


@each("name", sorted(LESSONS))
def test_stage_of_a_running_plant_shows_nothing_of_the_simulated_run(name: str) -> None:
    """Beside states and readings a body shows only what is constant in a simulated run: no moment of one stands beside a plant."""
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.start())
    try:
        routine = device_design(lesson, outcome).routine
    except DeviceError:  # no code for a device
        return
    stage, n = outcome.stage and (outcome.stage.plain or outcome.stage), len(routine.x_names)
    rows = [np.zeros((2, len(names))) for names in (routine.x_names, routine.y_names, routine.u_names)]
    if stage is None or stage.xhat is None or stage.xhat.shape[1] < n or n < 2 or measured_states(routine, *rows) is None:
        return
    beside = stage.x[:, n:stage.x.shape[1] - stage.readings]
    assert np.array_equal(np.ptp(beside, axis=0), np.zeros(beside.shape[1])), "a live page cannot know this: give the stage a `plain` one"


@each("language, live", [("en", "Live"), ("zh", "实时")])
def test_page_of_a_running_plant_offers_no_other_time_than_now(language: str, live: str, tmp_path_factory) -> None:
    lesson, design, desk = desk_for("noise", tmp_path_factory.mktemp("page"), Clock())
    screen = RecordedScreen(Look(language, width="phone"))
    session = Session({"noise": live_lesson(lesson, lesson.start(), desk)}, screen, "noise", language, clock=Clock())
    session.open()
    for k in range(30):
        feed(desk, line(design, k))
    for command in (LinesCame(1, lambda: None), Play(), Seek(0.0), PageSeen(1)):
        session.post(command)
        session.step()
    assert not session.picture.state.moving and session.picture.state.t == session.picture.horizon > 0
    parts = next(str(value) for value in screen.values.values() if 'class="ol-parts"' in str(value))
    assert live in parts and 'data-part="tasks"' not in parts
    offered = [str(value) for place, value in screen.values.items() if place[1] == "options"]
    assert not any(phrases.PLAY(language) in words for words in offered) and any(phrases.UNDO(language) in words for words in offered)


def test_hidden_page_is_given_no_places_until_it_draws_again(tmp_path) -> None:
    clock = Clock()
    lesson, _, desk = desk_for("noise", tmp_path, clock)
    outcome = lesson.compute(lesson.start())
    assert not desk.moves(3)  # it has had no picture yet
    for _ in range(3):
        desk.shown(3, outcome)
        assert desk.moves(3) == (clock.now < 101.0)
        clock.advance(2.5)
    assert not desk.moves(3) and desk.wants(3)
    desk.hear(3, desk.number(3))
    assert desk.moves(3)


def test_drive_stays_within_its_limits_and_ends_with_the_page() -> None:
    drive, T = Drive(2.0, 10.0), 0.1
    assert drive.input(np.array([5.0]), T, 0.0).tolist() == [0.0]
    drive.switch_on("page", 0.0)
    sent = [float(drive.input(np.array([5.0]), T, 0.01 * k)[0]) for k in range(4)]
    assert sent == [1.0, 2.0, 2.0, 2.0]
    drive.hear("another page", 1.0)
    assert drive.runs(PAGE_GONE_S) and drive.input(np.array([5.0]), T, PAGE_GONE_S + 0.01).tolist() == [0.0]
    drive.hear("page", 2.0)
    assert not drive.runs(2.0) and drive.ended == "page"  # it comes back only by the button


@each("wrong", [np.nan, np.inf, -np.inf])
def test_input_that_is_no_number_is_sent_as_zero(wrong: float) -> None:
    drive = Drive(2.0)
    drive.switch_on("page", 0.0)
    assert drive.input(np.array([1.0, wrong]), 0.1, 0.0).tolist() == [0.0, 0.0]


def test_desk_sends_the_feedback_of_the_prediction_and_zero_once_the_page_is_gone(tmp_path) -> None:
    clock = Clock()
    _, design, desk = desk_for("separation", tmp_path, clock, Drive(1e9))
    K, r = feedback_of(design.routine)
    for k in range(20):
        answer = feed(desk, line(design, k))
    assert answer == input_line(np.zeros(3)) and not desk.driving
    desk.toggle_drive(7)
    answer = feed(desk, line(design, 20))
    assert answer == input_line(r - K @ desk.observer.predicted) and desk.driving
    assert desk.idle() == b""
    clock.advance(PAGE_GONE_S + 0.1)
    assert desk.idle() == input_line(np.zeros(3)) and not desk.driving
    assert any("was gone" in words("en") for words in desk.said(7))
    desk.toggle_drive(7)
    desk.leave(7)
    assert not desk.driving


def test_line_of_inputs_has_a_checksum() -> None:
    words = b"u,1.0,-0.5"
    assert input_line([1.0, -0.5]) == words + f"*{reduce(xor, words):02X}\n".encode()


def test_device_that_is_switched_on_again_is_followed_anew(tmp_path) -> None:
    """Its clock begins at 0 again; the record ends there, so that its times rise."""
    _, design, desk = desk_for("noise", tmp_path, Clock())
    desk.toggle_record()
    for k in range(100):
        feed(desk, line(design, k))
    for k in range(60):
        feed(desk, line(design, k))
    assert desk.observer.restarts == 1 and desk.observer.disordered == RESET_LINES and not desk.recording
    alone = LiveObserver(design.routine)
    reader = LineReader(("u",), ("y",))
    for k in range(RESET_LINES - 1, 60):
        for sample in reader.feed(line(design, k)):
            step = alone.take(sample)
    assert np.array_equal(step.xhat, desk.shown(0, LESSONS["noise"].compute(LESSONS["noise"].start()))[0].stage.xhat[-1, :len(step.xhat)])


def test_silence_and_resumption_are_said(tmp_path) -> None:
    clock = Clock()
    _, design, desk = desk_for("noise", tmp_path, clock)
    assert "No line has come yet" in desk.said(0)[0]("en")
    feed(desk, line(design, 0))
    clock.advance(5.0)
    assert any("No line for 5.0 s" in words("en") for words in desk.said(0))
    feed(desk, line(design, 1))
    assert not any("No line for" in words("en") for words in desk.said(0))


def test_page_that_draws_slowly_is_given_time(tmp_path) -> None:
    clock = Clock()
    lesson, _, desk = desk_for("noise", tmp_path, clock)
    outcome = lesson.compute(lesson.start())
    desk.shown(3, outcome)
    assert not desk.wants(3)
    clock.advance(1.2)
    desk.hear(3, desk.number(3))
    clock.advance(0.3)
    assert not desk.wants(3)
    clock.advance(0.1)
    assert desk.wants(3)
    desk.shown(3, outcome)
    clock.advance(2.5)
    assert desk.wants(3)  # the picture was lost


@pytest.mark.slow
def test_simulated_device_takes_inputs_with_a_checksum_alone_and_stops_without_them() -> None:
    lesson = LESSONS["saturation"]
    outcome = lesson.compute(lesson.start())
    design, s = device_design(lesson, outcome), outcome.run.scenario
    files = simulator_files(design, discretise(s.plant, design.routine.period), s.x0)
    lines = LineReader(("u",), ("y",) * len(design.routine.y_names))

    def next_input(read) -> float:
        while True:
            samples = [*lines.feed(read(5.0) or b"")]
            if samples:
                return float(samples[-1].u[0])

    with simulated(files, 100_000, driven=True) as port:
        assert port.send is not None
        assert next_input(port) == 0.0
        for bad in (b"u,2.0\n", b"u,2.0*00\n", b"u,nan*5A\n", b"2.0*00\n", b"x" * 3000 + b"\n", b"\xff\x00\n"):
            port.send(bad)
        end = time.monotonic() + 0.2
        while time.monotonic() < end:
            assert next_input(port) == 0.0
        port.send(input_line([1.5]))
        while next_input(port) != 1.5:
            port.send(input_line([1.5]))
        while next_input(port) != 0.0:  # nothing is sent any more
            pass


@each("options, why", [(["--drive", "1", "--simulate"], "--drive needs --page"), (["--drive", "1", "--page", "--stdin"], "takes answers"),
                       (["--drive", "0", "--page", "--simulate"], "is no limit"),
                       (["--drive", "nan", "--page", "--simulate"], "is no limit")])
def test_drive_is_refused_where_nothing_could_switch_it_off(options: list[str], why: str, capsys) -> None:
    try:
        status = main(["live", "separation", *options])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2 and why in capsys.readouterr().err


def test_design_without_feedback_cannot_drive(capsys) -> None:
    assert main(["live", "noise", "--simulate", "--page", "0", "--drive", "1"]) == 2
    assert "feeds nothing back" in capsys.readouterr().err


def test_live_lesson_asks_no_prediction_and_keeps_the_design(tmp_path) -> None:
    lesson, _, desk = desk_for("kalman", tmp_path, Clock())
    given = lesson.start()
    live = live_lesson(lesson, given, desk)
    assert live.start().values == given.values and not live.path and not live.tasks and replace(live, live=None).live is None
    assert all(not prose.options for prose in live.words.values())
