"""Lesson 21: what must come out of its records, and a person's own record in it."""

from __future__ import annotations

import re
import runpy
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from observer_lab.cli.entry import main
from observer_lab.cli.records import columns_of
from observer_lab.colours import COLOURS, rgb
from observer_lab.course.figures.scene import Stage
from observer_lab.course.scenes import entry_values
from observer_lab.engine import Plant, to_json
from observer_lab.engine.identification import read_record
from observer_lab.lessons import LESSONS
from observer_lab.lessons.record.below import COLUMNS, band_colour
from observer_lab.lessons.record.data import TRUTHS, record_of
from observer_lab.lessons.record.own import with_record
from observer_lab.lessons.record.study import Study
from observer_lab.lessons.record.trace import ASIDE, EXACT, FAULT, OUTPUT, READINGS, RING, STRIP
from observer_lab.page.stage.body_extent import reach
from observer_lab.page.stage.viewpoint import body_scale, round_plant

LESSON = LESSONS["record"]
TEXT = "t [s],gas [ft3/min],y [%]\n"


def metrics(**changes: object) -> dict[str, float]:
    return dict(LESSON.compute(LESSON.apply(LESSON.start(), changes)).metrics)


def csv() -> str:
    record = record_of("spring", 5).record
    rows = zip(record.t, record.u[:, 0], record.y[:, 0], strict=True)
    return TEXT + "".join(f"{t:.3f},{u},{y:.6f}\n" for t, u, y in rows)


@pytest.mark.parametrize("data, order", [("spring", 2), ("tanks", 2), ("masses", 4)])
def test_a_simulated_record_gives_its_order_poles_noise_and_a_consistent_filter(data: str, order: int) -> None:
    found = metrics(data=data, order=order)
    assert found["suggested"] == order and found["away"] < 3
    assert found["nis_low"] < found["mean_nis"] < found["nis_high"] and found["white_p"] > 0.01
    assert found["sensor"] == pytest.approx(TRUTHS[data].r, rel=0.2)


def test_the_smoother_is_nearer_to_the_truth_than_the_filter() -> None:
    for data, order in (("spring", 2), ("masses", 4)):
        found = metrics(data=data, order=order)
        assert found["smoother_error"] < 0.9 * found["filter_error"]


def test_the_measured_record_changes_and_the_lesson_says_so() -> None:
    record = record_of("furnace", 0).record
    assert record.rows == 296 and record.dt == pytest.approx(9.0)
    assert (record.u[0, 0], record.y[0, 0], record.y[-1, 0]) == (-0.109, 53.8, 57.0)  # as printed
    found = metrics(data="furnace")
    assert found["mean_nis"] > found["nis_high"] and found["fit"] > 80


def test_a_record_of_ones_own_opens_in_the_lesson() -> None:
    own = with_record(LESSON, read_record(csv(), inputs=("gas",), outputs=("y",)))
    outcome = own.compute(own.start())
    assert own.start()["data"] == "own" and outcome.metrics["nis_low"] < outcome.metrics["mean_nis"] < outcome.metrics["nis_high"]
    assert {f.id for f in own.figures(outcome)} == {f.id for f in LESSON.figures(LESSON.compute(LESSON.start()))}
    other = own.compute(own.apply(own.start(), {"data": "spring"}))
    assert dict(other.metrics) == metrics()


def test_signs_of_a_page_are_taken_out_of_names() -> None:
    record = read_record(csv().replace("gas", "<b>g$"), inputs=("<b>g$",), outputs=("y",))
    found = with_record(LESSON, record)
    study = found.compute(found.start()).study
    assert not set("<>$") & set("".join(study.found.record.input_names))


def test_run_takes_a_file_and_refuses_in_one_sentence(tmp_path, capsys) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(csv(), encoding="utf-8")
    assert main(["run", "record", "--data", str(path), "--columns", "u=gas,y=y"]) == 0
    assert "mean_nis" in capsys.readouterr().out
    for words in (["kalman", "--data", str(path)], ["record", "--data", str(tmp_path / "none.csv")],
                  ["record", "--data", str(path), "--columns", "x=gas"],
                  ["record", "--data", str(path), "--columns", "u=gas,y=y", "--plant", str(tmp_path / "no.json")],
                  ["record", "--data", str(path), "--state", "x"]):
        assert main(["run", *words]) == 2
        said = capsys.readouterr().err
        assert said.startswith("observer-lab: ") and said.count("\n") == 1 and "Traceback" not in said


def test_columns_are_named_one_by_one() -> None:
    assert columns_of("t=time, u=a,u=b,y=c d") == ("time", ("a", "b"), ("c d",))
    assert columns_of("t=time[ms] u=gas rate y=T1, T2") == ("time[ms]", ("gas rate",), ("T1", "T2"))
    assert columns_of("") == ("", (), ())


def test_what_was_read_is_said(tmp_path, capsys) -> None:
    path = tmp_path / "mine.csv"
    path.write_text(csv().replace("t [s]", "t"), encoding="utf-8")
    assert main(["run", "record", "--data", str(path), "--columns", "u=gas y=y"]) == 0
    said = capsys.readouterr().out
    assert "Step 0.1 s, 800 rows, 80 s." in said and "names no unit; its numbers were read as seconds" in said
    own = with_record(LESSON, read_record(csv(), inputs=("gas",), outputs=("y",)))
    assert "Step 0.1 s, 800 rows, 80 s." in own.compute(own.start()).live("en")
    path.write_text(csv().replace(",0.0", ",-9999"), encoding="utf-8")
    assert main(["run", "record", "--data", str(path), "--columns", "t=t[ms] u=gas y=y", "--missing=-9999"]) in (0, 1)


def test_ones_own_plant_filters_ones_own_record(tmp_path, capsys) -> None:
    """The true plant on its record is consistent with the R of the simulation; a plant that is twice as fast is not."""
    (tmp_path / "mine.csv").write_text(csv(), encoding="utf-8")
    for name, stiffness, code in (("right", 4.0, 0), ("wrong", 16.0, 1)):
        file = tmp_path / f"{name}.json"
        file.write_text(to_json(Plant([[0, 1], [-stiffness, -0.8]], [[0], [1]], [[1, 0]])), encoding="utf-8")
        run = ["run", "record", "--data", str(tmp_path / "mine.csv"), "--columns", "u=gas y=y", "--plant", str(file)]
        assert main(run) == code
        said = capsys.readouterr().out
        assert float(re.search(r"sensor = (\S+)", said)[1]) == pytest.approx(TRUTHS["spring"].r, rel=0.2) or code


def with_gaps() -> str:
    """Every seventeenth reading is missing."""
    head, *rows = csv().splitlines()
    return "\n".join([head, *(row if k % 17 else row.rpartition(",")[0] + "," for k, row in enumerate(rows, start=1))]) + "\n"


def exported(tmp_path: Path, to: str, name: str, text: str, *more: str) -> Path:
    """What `export record` writes of a person's own log."""
    (tmp_path / "mine.csv").write_text(text, encoding="utf-8")
    assert main(["export", "record", "--data", str(tmp_path / "mine.csv"), "--columns", "u=gas y=y", "--to", to,
                 "-o", str(tmp_path / name), *more]) == 0
    return tmp_path / name


@pytest.mark.slow
@pytest.mark.parametrize("text, more", [(csv(), ()), (with_gaps(), ()), (csv(), ("--set", "delay=4"))], ids=["whole", "gaps", "delay"])
def test_a_script_of_ones_own_record_filters_new_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str,
                                                          more: tuple[str, ...]) -> None:
    """The script proves itself; its `estimate` goes through the second half alone, and soon gives what it gives in the whole record."""
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    names = runpy.run_path(str(exported(tmp_path, "python", "own.py", text, *more)))
    record = read_record(text, inputs=("gas",), outputs=("y",))
    half, late = record.rows // 2, slice(-100, None)
    whole, part = (names["estimate"](record.t[rows], record.u[rows], record.y[rows]) for rows in (slice(None), slice(half, None)))
    assert len(part[1]) == record.rows - half - int(names["delay"])
    assert np.allclose(part[1][late], whole[1][late], rtol=0, atol=1e-3)
    assert np.all(part[2][late] > 0.99 * whole[2][late])  # half the rows leave no less doubt
    assert np.nanstd(record.y[late] - whole[1][late]) < 2 * TRUTHS["spring"].r  # readings lie beside the estimate by their noise
    with pytest.raises(ValueError, match=r"made for a step of 0\.1 s"):
        names["estimate"](2 * record.t, record.u, record.y)


def test_the_table_of_estimates_holds_what_the_page_shows(tmp_path: Path) -> None:
    file = exported(tmp_path, "estimates", "table.csv", with_gaps())
    heads, *rows = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
    table = {name: np.array([float(row[k] or "nan") for row in rows]) for k, name in enumerate(heads)}
    own = with_record(LESSON, read_record(with_gaps(), inputs=("gas",), outputs=("y",)))
    study = own.compute(own.start()).study
    assert np.allclose(table["estimate y"][study.first:], study.estimate(False)[:, 0])
    assert np.allclose(table["smoothed y"][study.first:], study.estimate(True)[:, 0])
    read = np.isfinite(table["y"])
    assert 0.9 < read.mean() < 0.95 and np.all(table["sigma of estimate y"] > 0) and table["t [s]"][1] == pytest.approx(0.1)
    assert table["sigma of estimate y"][~read][2:].mean() > 1.05 * table["sigma of estimate y"][read][40:].mean()  # a gap leaves more doubt


def test_other_lessons_have_no_table_of_estimates(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", "kalman", "--to", "estimates"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="Octave is not installed")
def test_a_matlab_file_of_a_record_with_gaps_proves_itself(tmp_path: Path) -> None:
    exported(tmp_path, "matlab", "own.m", with_gaps())
    done = subprocess.run(["octave-cli", "--quiet", "--no-init-file", "--eval", "own(false)"], cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout.count("agree to 1e-06") == 1, done.stderr[-2000:]


def painted(image: np.ndarray) -> np.ndarray:
    """The pixels of a panel whose colour is not that of its ground, column by column."""
    return (image != image[0]).any(axis=2)


def test_the_panel_shows_the_output_of_the_record_and_the_bar_where_the_run_is() -> None:
    """The trace is as high as the output at each moment of the run. It stands right of the fitted part, whose ground is greyer."""
    for share in (30, 50):
        outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"share": share}))
        stage = outcome.stage
        assert stage is not None and stage.picture is not None
        image, y = stage.picture.image, stage.x[:, 0]
        ground = (image[0] == image[0, -1]).all(axis=1).astype(int)  # whether it is that of the rows that judge
        split = int(np.flatnonzero(np.diff(ground) != 0)[0]) + 1
        assert ground[0] < ground[-1] and split == pytest.approx(share / 100 * len(ground), abs=2)
        trace = (image == np.array(rgb(COLOURS[OUTPUT]))).all(axis=2)
        middle = np.array([np.flatnonzero(column).mean() for column in trace.T])[split:]
        at = np.interp(np.linspace(0, len(y) - 1, len(middle)), np.arange(len(y)), y)
        assert np.corrcoef(-middle, at)[0, 1] > 0.97
        record, wide = outcome.study.found.record, stage.picture.size[0]
        for k in (0, len(y) // 2, len(y) - 1):
            across = stage.body.pose(stage.x[k].tolist(), 1.0)["now"].position[0]
            when = (stage.t[k] + outcome.study.t[0] - record.t[0]) / (record.t[-1] - record.t[0])
            assert across == pytest.approx(wide * (when - 0.5))


def test_the_band_on_the_panel_is_two_standard_deviations_of_an_innovation_to_either_side() -> None:
    """Its height over the unused part is that of ±2√S, which a filter written here finds; a larger Q makes it wider. The fit has none."""
    high = []
    for factor in (0.1, 1.0, 100.0):
        outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"factor": factor}))
        assert outcome.stage is not None and outcome.stage.picture is not None
        image, study = outcome.stage.picture.image, outcome.study
        fitted = study.found.fitted
        A, C, P = fitted.plant.A, np.asarray(fitted.plant.C), np.eye(fitted.plant.n)
        for _ in range(2000):  # the Riccati recursion to its steady state
            S = C @ P @ C.T + fitted.R
            P = A @ (P - P @ C.T @ np.linalg.solve(S, C @ P)) @ A.T + factor * fitted.Q
        readings = np.concatenate([study.given.clean[:, 0], study.given.record.y[:, 0]])
        pixels = 4 * float(np.sqrt(S[0, 0])) / float(np.ptp(readings)) * 0.84 * len(image)
        band = (image == band_colour()).all(axis=2)
        split = round(study.first / (study.found.record.rows - 1) * image.shape[1])
        assert not band[:, :split].any()
        least = min(int(np.ptp(np.flatnonzero(column))) for column in painted(image)[:, split + 4:].T)
        assert least >= 0.9 * pixels, factor
        high.append(float(np.median([np.ptp(np.flatnonzero(column)) for column in band[:, split + 4:].T if column.any()])))
    assert high[0] < high[1] < high[2] - 10


def test_the_tubes_of_further_outputs_stand_below_the_panel_as_it_is_seen() -> None:
    """No part of a tube on the floor covers the panel; a record of one output has none, and its panel stands near the floor."""
    t = np.arange(200) * 0.1
    rows = np.column_stack([np.sin(t), np.cos(1.3 * t), np.sin(0.7 * t) + 0.1 * np.cos(5 * t)])
    lines = [",".join(f"{value:.6g}" for value in row) for row in np.column_stack([t, rows])]
    record = read_record("\n".join(["t,u,a,b", *lines]), inputs=("u",), outputs=("a", "b"))
    for lesson, more in ((with_record(LESSON, record), True), (LESSON, False)):
        stage = lesson.compute(lesson.start()).stage
        assert stage is not None and stage.picture is not None
        (eye, _), (_, deep, middle) = round_plant(body_scale(reach(stage)))["plant"], stage.picture.place
        foot, poses = middle - stage.picture.size[1] / 2, stage.body.pose(stage.x[0].tolist(), 1.0)
        assert ("lamp 0" in poses) == more and foot > 0
        if more:
            lamp = poses["lamp 0"].position
            assert eye[2] + (lamp[2] - eye[2]) * (deep - eye[1]) / (lamp[1] - eye[1]) < foot


def test_the_collar_stands_on_the_trace_at_the_output_and_its_ghost_at_the_estimate() -> None:
    """The collar is as high as the trace behind it; its ghost as much higher or lower on the panel as the estimate is off."""
    stage = LESSON.compute(LESSON.start()).stage
    assert stage is not None and stage.xhat is not None and stage.picture is not None
    image, (wide, high), (_, _, middle) = stage.picture.image, stage.picture.size, stage.picture.place
    study = LESSON.compute(LESSON.start()).study
    span = float(np.ptp(np.concatenate([study.given.clean[:, 0], study.given.record.y[:, 0]])))
    for k in range(0, len(stage.t), 37):
        collar, ghost = (stage.body.pose(states[k].tolist(), stage.body.gain)["reading"].position for states in (stage.x, stage.xhat))
        column = min(int((collar[0] / wide + 0.5) * image.shape[1]), image.shape[1] - 1)
        row = (middle + high / 2 - collar[2]) / high * image.shape[0]
        drawn = np.flatnonzero((image == np.array(rgb(COLOURS[OUTPUT]))).all(axis=2)[:, column])
        assert drawn.min() - 4 <= row <= drawn.max() + 4, k
        assert ghost[2] - collar[2] == pytest.approx(0.84 * 2.5 * (stage.xhat[k, 0] - stage.x[k, 0]) / span)


def test_the_jumps_of_a_faulty_sensor_are_painted_on_the_panel() -> None:
    """Its readings reach farther from the true output than those of the faultless sensor."""
    def farthest(**values: object) -> int:
        stage = LESSON.compute(LESSON.apply(LESSON.start(), values)).stage
        assert stage is not None and stage.picture is not None
        grey = (stage.picture.image == np.array(rgb(COLOURS[READINGS]))).all(axis=2)
        trace = (stage.picture.image == np.array(rgb(COLOURS[OUTPUT]))).all(axis=2)
        rows = np.arange(len(grey))[:, None]
        top, foot = np.where(trace, rows, len(grey)).min(axis=0), np.where(trace, rows, 0).max(axis=0)
        return int(np.where(grey, np.maximum(top - rows, rows - foot), 0).max())
    assert farthest(data="faulty") > 1.5 * farthest(data="spring") > 0


def test_marked_readings_are_those_that_jump_are_set_aside_or_come_from_the_second_sensor() -> None:
    """A dot or a ring of its colour stands at the column of each of them, and nowhere without them."""
    def columns(role: str, **values: object) -> tuple[np.ndarray, Study]:
        outcome = LESSON.compute(LESSON.apply(LESSON.start(), values))
        assert outcome.stage is not None and outcome.stage.picture is not None
        marked = (outcome.stage.picture.image[STRIP:-STRIP] == np.array(rgb(COLOURS[role]))).all(axis=2)
        return np.flatnonzero(marked.any(axis=0)), outcome.study

    for role, values in ((FAULT, {"data": "faulty"}), (ASIDE, {"data": "faulty", "gate": "0.999"}), (EXACT, {"second": "slow"})):
        assert not len(columns(role)[0])
        found, study = columns(role, **values)
        rows = {FAULT: lambda s: np.flatnonzero(s.given.jumps[:, 0]), ASIDE: lambda s: np.flatnonzero(s.judged.set_aside),
                EXACT: lambda s: np.arange(s.first, s.found.record.rows)[10::10]}[role](study)
        at = rows / (study.found.record.rows - 1) * (COLUMNS - 1)
        assert len(at) and np.abs(at[:, None] - found).min(axis=0).max() <= RING[1] + 1
        assert np.abs(at[:, None] - found).min(axis=1).max() <= RING[0] + 1


def shown_below(**values: object) -> tuple[Stage, np.ndarray, int]:
    """The stage of a design, the pixels of the panel's lower part, and the first column of the rows that judge."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), values))
    stage = outcome.stage
    assert stage is not None and stage.picture is not None
    image = stage.picture.image
    return stage, image[round(0.6 * len(image)):], round(outcome.study.first / (outcome.study.found.record.rows - 1) * COLUMNS) + 4


def drawn_heights(image: np.ndarray, colour: np.ndarray) -> np.ndarray:
    """How far above the middle of a picture a line of this colour stands, column by column, as a share of half its height."""
    high, rows = len(image), np.arange(len(image))[:, None]
    line = (image == colour).all(axis=2)
    return 1 - 2 * (rows * line).sum(axis=0) / np.maximum(line.sum(axis=0), 1) / high


def test_the_band_of_innovations_grows_with_the_root_of_their_covariance_and_its_scale_stays() -> None:
    """The band is ±2√S by the gains of the run; the edge, which the label says, is the same for every factor of Q."""
    said, ratio = set(), []
    for factor in (0.1, 1.0, 100.0):
        design = LESSON.apply(LESSON.start(), {"below": "innovations", "factor": factor})
        stage, image, split = shown_below(below="innovations", factor=factor)
        name = str(stage.body.labels[-1][0])
        said.add(name)
        covered = (image != image[2, -1]).any(axis=2)[:, split:]
        tall = float(np.median([np.ptp(np.flatnonzero(column)) for column in covered.T])) - 8  # the pen's width
        edge = float(name.rpartition("±")[2])
        ratio.append(tall / len(image) * 2 * edge / (4 * np.sqrt(float(LESSON.compute(design).gains["S"][0, 0]))))
    assert len(said) == 1 and ratio == pytest.approx([1.0] * 3, rel=0.12)


def test_the_error_below_is_what_the_ghost_is_off_and_the_smoother_is_nearer() -> None:
    """The line follows the ghost less the collar of the same run; that of the smoother has a smaller mean square."""
    blue, orange = (np.array(rgb(COLOURS[role])) for role in ("second", "estimate"))
    stage, image, split = shown_below(below="error")
    away = stage.xhat[:, 0] - stage.x[:, 0]
    line = drawn_heights(image, blue)[split - 4:]
    at = np.interp(np.linspace(0, len(away) - 1, len(line)), np.arange(len(away)), away)
    assert np.corrcoef(line, at)[0, 1] > 0.95 and not (image == orange).all(axis=2).any()
    _, both, split = shown_below(below="error", smoother=True)
    smoother = drawn_heights(both, orange)[split - 4:]
    assert 0.1 < np.std(smoother) / np.std(line) < 0.8


def test_the_deviation_below_is_flat_with_one_sensor_and_falls_at_each_exact_reading() -> None:
    def heights(**values: object) -> np.ndarray:
        _, image, split = shown_below(below="deviation", **values)
        return drawn_heights(image, np.array(rgb(COLOURS["estimate"])))[split:-4]
    flat, comb = heights(), heights(second="slow")
    assert np.ptp(flat) < 0.02 and comb.min() < flat.min() - 0.4
    low = comb < (comb.min() + flat.min()) / 2
    assert np.count_nonzero(np.diff(low.astype(int)) == 1) == pytest.approx(800 / 2 / 10, abs=2)


@pytest.mark.parametrize("data, states", [("spring", 2), ("masses", 4)])
def test_columns_above_the_bar_are_the_states_and_those_of_the_model_are_orange(data: str, states: int) -> None:
    """The bar stands at what noise alone gives; the order colours as many columns; the question's stage has none before its answer."""
    for order in (1, states, states + 2):
        stage, *_ = shown_below(below="values", data=data, order=order)
        parts, poses = {part.name: part for part in stage.body.parts}, stage.body.pose(stage.x[0].tolist(), 1.0)
        columns = [name for name in parts if name.startswith("column")]
        tops = [poses[name].position[2] + parts[name].shape.size[2] / 2 for name in columns]
        assert sum(top > poses["edge"].position[2] for top in tops) == states
        assert [parts[name].colour == COLOURS["estimate"] for name in columns] == [k < order for k in range(len(columns))]
    asked = next(k for k, scene in enumerate(LESSON.path) if scene.id == "predict")
    before = LESSON.compute(LESSON.apply(LESSON.start(), entry_values(LESSON.path, asked, LESSON.start()))).stage
    assert before is not None and not [part for part in before.body.parts if part.name.startswith("column")]


def test_the_carriage_goes_between_the_panel_and_the_columns() -> None:
    """The bench and its columns begin before what the tube stands on and the tube itself, wherever these are."""
    stage, *_ = shown_below(below="values")
    parts, poses = {part.name: part.shape for part in stage.body.parts}, stage.body.pose(stage.x[0].tolist(), 1.0)
    front = min(poses["base"].position[1] - parts["base"].size[1] / 2, poses["reading"].position[1] - parts["reading"].radius)
    backs = [poses[name].position[1] + parts[name].size[1] / 2 for name in parts if name == "bench" or name.startswith("column")]
    assert len(backs) > 1 and max(backs) < front
    assert [str(words) for words, _ in stage.body.labels if str(words).isdigit()] == [str(k) for k in range(1, len(backs))]
