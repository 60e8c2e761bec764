"""What must come out of lesson 20: the sheet's own numbers, no bias with a state for the load, e^{(A − LC)t}, and what play leaves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from laws import each
from scipy.linalg import expm

from observer_lab.course.lesson import Outcome
from observer_lab.engine import observability
from observer_lab.lessons import LESSONS
from observer_lab.lessons.arm.loop import LOAD_AT, WINDING
from observer_lab.lessons.arm.study import Study, sheet_rows
from observer_lab.plants.arm import ANGLE_INDEX, ARM_THICK, FLANK, FLANK_LONG, LOAD_INDEX, MOTOR_DATA, PARAMETERS, PLAY_GAIN, plant
from observer_lab.plants.bodies.body import Pose

LESSON = LESSONS["arm"]
FAST = (-30 - 10j, -30 + 10j, -30 + 0j)


def outcome(**values: Any) -> Outcome[Study]:
    return LESSON.compute(LESSON.apply(LESSON.start(), values))


def test_the_printed_constants_of_the_motor_agree_with_each_other() -> None:
    """No-load speed, stall torque and current and the speed constant from R, k and the no-load current, as the sheet prints them."""
    for name, printed, computed, _ in sheet_rows():
        assert computed == pytest.approx(printed, rel=0.003), name("en")


def test_the_plant_is_the_motor_behind_the_gear() -> None:
    """Driven to a constant speed by 24 V without friction the joint turns at the motor's ideal no-load speed over the ratio."""
    p = PARAMETERS
    A = plant().A
    still = np.linalg.solve(np.array([[A[0, 0], A[0, 1]], [A[1, 0], 0.0]]), [-MOTOR_DATA.voltage / MOTOR_DATA.inductance, 0.0])
    assert still == pytest.approx([0.0, MOTOR_DATA.voltage / (p.ratio * MOTOR_DATA.torque_constant)], abs=1e-9)
    assert p.reflected == pytest.approx((91 / 6) ** 2 * 142e-7) and observability(plant()).rank == 4


def direction(pose: Pose) -> np.ndarray:
    """Where a rod points, across and up: the third axis of its rotation."""
    w, x, y, z = pose.wxyz
    return np.array([2 * (x * z + w * y), 1 - 2 * (x * x + y * y)])


@each("target", [30.0, 60.0, 115.0])
def test_the_dotted_line_is_the_target_and_the_arc_leads_from_it_to_the_arm(target: float) -> None:
    stage = outcome(target=target, cancel=False).stage
    assert stage is not None and stage.body.marks is not None and stage.xhat is not None
    for k in range(0, len(stage.t), 40):
        x = stage.x[k].tolist()
        poses, arm = stage.body.pose(x, 1.0), x[ANGLE_INDEX]
        turn = np.radians(target)
        assert direction(poses["target 4"]) == pytest.approx([np.cos(turn), np.sin(turn)], abs=1e-9)
        apart = abs(np.degrees(arm) - target)
        words = stage.body.marks(x, stage.xhat[k].tolist(), 1.0).words
        assert float(words[2][0].rstrip("°")) == pytest.approx(apart, rel=0.06, abs=0.05) and (words[2][1][2] < 0) == (apart < 0.5)
        if apart >= 0.5:
            long = sum(pose.scale[2] for name, pose in poses.items() if name.startswith("away "))
            foot, joint = (poses[name].position for name in ("away 0", "arm"))
            radius = np.hypot(foot[0] - joint[0], foot[2] - joint[2])
            assert long == pytest.approx(radius * np.radians(apart), rel=0.02)


def test_the_arrows_of_load_and_voltage_carry_their_sizes() -> None:
    found = outcome(load=1.2)
    stage, run = found.stage, found.run
    assert stage is not None and run is not None and stage.body.marks is not None and stage.xhat is not None
    for k in range(0, len(stage.t), 30):
        load, voltage, _ = stage.body.marks(stage.x[k].tolist(), stage.xhat[k].tolist(), 1.0).words
        said = [float(words.split(" ")[2].replace("−", "-")) for words, _, _ in (load, voltage)]
        assert said == pytest.approx([run.x[k, LOAD_INDEX], run.u_applied[k, 0]], abs=0.0051, rel=0.06)
        assert (load[1][2] > 0) == (run.t[k] >= LOAD_AT)


@each("load", [-3.0, 0.4, 1.5])
def test_a_constant_load_is_found_without_bias_and_the_arm_comes_back(load: float) -> None:
    found = outcome(load=load, observer_poles=FAST)
    run = found.run
    assert run is not None and abs(run.e[-1, LOAD_INDEX]) < 1e-9 and abs(found.metrics["droop"]) < 0.01
    assert outcome(load=load, load_state=False).metrics["load_error"] == pytest.approx(abs(load))


def test_the_error_is_the_exponential_of_a_less_lc_whatever_the_controller_and_the_supply() -> None:
    for values in ({}, {"u_max": 1.0}, {"target": 120.0, "controller_poles": (-15 - 3j, -15 + 3j)}, {"cancel": False}):
        found = outcome(observer_poles=FAST, **values)
        run = found.run
        assert run is not None
        error = plant().A - found.gains["L"] @ plant().C
        begin = run.index(LOAD_AT)
        for k in (0, 5, 40, 200):
            assert np.allclose(run.e[begin + k], expm(error * run.scenario.dt * k)[:, LOAD_INDEX] * 1.5, atol=1e-8), values
        assert np.poly(error / 100) == pytest.approx(np.real(np.poly(np.array([WINDING, *FAST]) / 100)), rel=1e-8)


def test_the_gain_of_the_load_is_the_product_of_the_poles() -> None:
    L = outcome(observer_poles=FAST).gains["L"]
    product = np.prod([WINDING, *FAST]).real
    assert L[LOAD_INDEX, 0] == pytest.approx(-PARAMETERS.inertia * MOTOR_DATA.inductance / MOTOR_DATA.resistance * product, rel=1e-9)


def test_the_loop_at_rest_is_that_of_its_equations() -> None:
    for values in ({}, {"cancel": False}, {"load_state": False}):
        found = outcome(**values)
        run, rest = found.run, found.study.rest
        assert run is not None and rest is not None
        assert np.allclose(run.x[-1], rest[0], atol=2e-3) and np.allclose(run.xhat[-1], rest[1], atol=2e-3)


def test_half_the_play_is_a_bias_that_no_pole_removes_and_an_encoder_at_the_joint_does() -> None:
    for poles in ((-14 - 6j, -14 + 6j, -12 + 0j), FAST):
        assert outcome(gap=1.0, observer_poles=poles).metrics["angle_belief"] == pytest.approx(0.5, abs=1e-3)
    assert outcome(gap=1.0, encoder="joint", counts=16384.0).metrics["angle_error"] < 0.03


def test_a_faster_observer_is_deceived_more_by_play_and_trembles_more_with_counts() -> None:
    def rising(name: str, **values: Any) -> None:
        sizes = [outcome(observer_poles=tuple(s * q for q in FAST), **values).metrics[name] for s in (0.4, 0.8, 1.6)]
        assert sizes == sorted(sizes) and sizes[2] > 3 * sizes[0], (values, sizes)
    rising("false_load", gap=1.0)
    rising("load_error", encoder="joint")


def test_on_the_motor_the_joint_has_more_counts() -> None:
    steps = [outcome(encoder=place).study.step for place in ("exact", "motor", "joint")]
    assert steps == pytest.approx([0.0, 2 * np.pi / 2000 / (91 / 6), 2 * np.pi / 2000])


def test_the_determinant_of_the_observability_matrix_is_what_the_task_says() -> None:
    p, P = PARAMETERS, plant()
    rows = np.vstack([P.C @ np.linalg.matrix_power(P.A, k) for k in range(4)])
    assert np.linalg.det(rows) == pytest.approx(p.torque * MOTOR_DATA.resistance / (p.inertia**2 * MOTOR_DATA.inductance), rel=1e-9)


def test_the_numbers_in_the_words_are_those_of_the_lesson() -> None:
    """In every language, where they stand."""
    solved = {task.id: outcome(**task.solution).metrics for task in LESSON.tasks}
    p = PARAMETERS
    play = solved["play"]
    said = {"step": (f"{-WINDING:.0f}", f"{p.inertia / p.reflected:.0f}", f"{outcome(gap=1.0).metrics['angle_belief']:.1f}°",
                     f"{outcome().metrics['holding']:.2f}"),
            "counts": (f"{solved['counts']['found_after']:.3f} s",),
            "play": (f"{play['angle_error']:.2f}°", f"{play['false_load']:.2f} N m", f"{play['found_after']:.2f} s"),
            "supply": (f"{solved['supply']['holding']:.2f} V", f"{solved['supply']['clipped_for']:.1f} s")}
    for prose in LESSON.words.values():
        where = {"step": " ".join(text for _, text in prose.steps), **{id: task.solution for id, task in prose.tasks.items()}}
        assert not [(id, number) for id, numbers in said.items() for number in numbers if number not in where[id]]


@pytest.mark.parametrize("gap", [0.0, 0.4, 3.0])
def test_the_flanks_on_the_stage_touch_the_arm_where_the_gear_is_in_contact(gap: float) -> None:
    """The gear's law: the arm less the motor lies within ± half of the play; a flank touches at either end of it."""
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), {"gap": gap}))
    stage, motor, half = outcome.stage, outcome.study.played.motor, np.radians(gap) / 2
    assert stage is not None

    def angle(pose: Pose) -> float:  # of a rod, above level, from the turn of its own z axis
        w, x, y, z = pose.wxyz
        return float(np.arctan2(1 - 2 * (x * x + y * y), 2 * (x * z + w * y)))
    for k in range(0, len(stage.t), 29):
        poses = stage.body.pose(stage.x[k].tolist(), 1.0)
        arm, low, high = (angle(poses[name]) for name in ("arm", "flank below", "flank above"))
        thick = np.arctan2(ARM_THICK + FLANK, FLANK_LONG)
        drawn = high - arm - thick, arm - low - thick
        assert sum(drawn) == pytest.approx(PLAY_GAIN * 2 * half, abs=1e-6)
        free = half - (outcome.run.x[k, ANGLE_INDEX] - motor[k])
        assert drawn[0] == pytest.approx(PLAY_GAIN * free, abs=1e-6)
