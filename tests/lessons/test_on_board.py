"""Scene "On the board": its bars come from the step that is exported, by the faults that its options name."""

import numpy as np
import pytest
from device_bodies import run_c, write_files

from observer_lab.course.guiding.questions import Asked
from observer_lab.devices import design_of_run
from observer_lab.export.devices.c_project import c_project
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS
from observer_lab.lessons.toolkit.questions import FAULTS, board_designs

GIVEN = {"noise": ({"speed": 1.0}, 0.05, 20), "arm": ({}, np.radians(1.0), 5), "kalman": ({}, 1e-3, 1)}


def started(name: str):
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.apply(lesson.start(), GIVEN[name][0]))
    return lesson, outcome


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(GIVEN))
def test_every_fault_gives_the_bits_of_the_compiled_step(tmp_path, name: str) -> None:
    for fault, (design, single) in board_designs(device_design(*started(name)), *GIVEN[name][1:]).items():
        folder = write_files(tmp_path / fault, c_project(design, "test", single))
        for flags in (["-O0"], ["-O3"]):
            assert run_c(folder, flags).endswith("every bit as in the lab's Python."), fault


@pytest.mark.parametrize("name, index", [("noise", 1), ("arm", 3)])
def test_bars_are_the_errors_of_a_plain_observer_under_these_faults(name: str, index: int) -> None:
    """A second loop, written here in NumPy, takes the model, the gain and the readings of the run."""
    lesson, outcome = started(name)
    design = design_of_run(outcome.run)
    tables = {each.name: np.array(each.values).reshape(each.shape) for each in design.routine.constants}
    A, B, C, L, K = (tables.get(key) for key in "ABCLK")
    start, y, x = np.array(design.routine.states[0].values), design.y, outcome.run.x
    _, step, late = GIVEN[name]

    def error(readings: np.ndarray) -> float:
        xhat, found = start, []
        for k, reading in enumerate(readings):
            u = design.u[k] if K is None else np.clip(design.r[k] - K @ xhat, tables["u_min"].ravel(), tables["u_max"].ravel())
            v = np.where(np.isnan(reading), 0.0, reading - C @ xhat)
            found.append(xhat[index])
            xhat = A @ xhat + B @ u + L @ v
        gap = x[:len(found), index] - np.array(found)
        return float(np.sqrt(np.mean(gap[len(found) // 3:] ** 2)))

    lost = y.copy()
    lost[4::5] = np.nan
    expected = [error(y), error(np.vstack([np.repeat(y[:1], late, axis=0), y[:-late]])), error(lost), error(step * np.round(y / step))]
    drawn = lesson.questions["board"](Asked(lesson, outcome, outcome))
    heights = [float(curve.y[-1]) for curve in drawn.run]
    assert np.allclose(heights, expected, rtol=1e-5)
    assert FAULTS[int(np.argmax(heights))] == "late" and abs(heights[0] / expected[0] - 1) < 1e-4


def test_bars_of_the_recursive_filter_are_the_errors_of_the_engine_filter_under_these_faults() -> None:
    lesson, outcome = started("kalman")
    watcher, truth, (_, step, late) = outcome.study.watcher, outcome.study.truth, GIVEN["kalman"]
    y = np.asarray(truth.y)[:len(truth.x)]
    lost = y.copy()
    lost[4::5] = np.nan

    def error(readings: np.ndarray) -> float:
        means = watcher.filter.run(watcher.start, readings, truth.u).means
        gap = truth.x[:len(means), 4] - means[:, 4]
        return float(np.sqrt(np.mean(gap[len(means) // 3:] ** 2)))

    expected = [error(y), error(np.vstack([np.repeat(y[:1], late, axis=0), y[:-late]])), error(lost), error(step * np.round(y / step))]
    drawn = lesson.questions["board"](Asked(lesson, outcome, outcome))
    heights = [1e-3 * float(curve.y[-1]) for curve in drawn.run]  # drawn in mm/s
    assert np.allclose(heights, expected, rtol=1e-5)
    assert FAULTS[int(np.argmax(heights))] == "late" and heights[1] > 10 * expected[0]
