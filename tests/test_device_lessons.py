"""Every lesson with an observer, filter or controller as a device: the page's estimate, and the same bits in C."""

import math

import numpy as np
import pytest
from device_bodies import run_c, write_files
from device_designs import random_design

from observer_lab.devices import Device, DeviceError, kalman_routine
from observer_lab.devices.derivatives import slope_of, with_slopes
from observer_lab.engine import Belief, KalmanFilter
from observer_lab.export.devices.folders import device_design, device_files
from observer_lab.lessons import LESSONS

NONE = {"observability"}  # lessons that have nothing for a device
SAMPLED = {"bilinear-observer": 0.05}  # lessons whose estimate differs on a device because its observer is sampled: share of the largest


def test_lessons_without_an_observer_say_so() -> None:
    for name in NONE:
        with pytest.raises(DeviceError, match="no observer, filter or controller"):
            device_design(LESSONS[name], LESSONS[name].compute(LESSONS[name].start()))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(LESSONS) - NONE - {"nonlinear"}))
def test_lesson_gives_the_page_estimate_and_the_same_bits_in_c(tmp_path, name: str) -> None:
    lesson = LESSONS[name]
    outcome = lesson.compute(lesson.start())
    gap = device_design(lesson, outcome).gap()
    assert gap is None or gap < SAMPLED.get(name, 1e-9)
    files = device_files(lesson, outcome, "token", "c")
    for flags in (["-O0"], ["-O3"]):
        assert run_c(write_files(tmp_path, files), flags).endswith("every bit as in the lab's Python.")


@pytest.mark.slow
@pytest.mark.parametrize("statistic", ["energy", "mean"])
@pytest.mark.parametrize("part", ["VL", "u1", "u3"])
def test_one_observer_of_the_bank_alone_gives_the_page_statistic_and_the_same_bits_in_c(tmp_path, part: str, statistic: str) -> None:
    """An unknown-input observer sees every fault but that of the coil that it ignores, as the bank's verdict on the page does."""
    lesson = LESSONS["fault-diagnosis"]
    alarms = {}
    for place in ("none", "u1", "HL"):
        outcome = lesson.compute(lesson.apply(lesson.start(), {"place": place, "statistic": statistic, "bias": 10.0, "loss": 100.0,
                                                               "force": 4.0, "rate": 1e-6}))
        design = device_design(lesson, outcome, part=part)
        gap = design.gap()
        assert gap is not None and gap < 1e-9
        alarms[place] = bool(design.expected()["alarm"].any())
    assert alarms == {"none": False, "u1": part != "u1", "HL": True}
    files = device_files(lesson, outcome, "token", "c", part=part)
    assert f"part {part}" in files["README.md"]
    for flags in (["-O0"], ["-O3"]):
        assert run_c(write_files(tmp_path, files), flags).endswith("every bit as in the lab's Python.")


def test_part_that_a_lesson_does_not_have_is_refused_with_those_that_it_has() -> None:
    for name, said in (("fault-diagnosis", "there are VL, HL, VR, HR, u1, u2, u3"), ("kalman", "leave the part out")):
        lesson = LESSONS[name]
        with pytest.raises(DeviceError, match=said):
            device_design(lesson, lesson.compute(lesson.start()), part="u9")


@pytest.mark.slow
def test_reduced_order_observer_gives_the_page_estimate_and_the_same_bits_in_c(tmp_path) -> None:
    """Readings are held over a period on a device, and the page's run is continuous: the two differ by that alone."""
    lesson = LESSONS["virtual-sensor"]
    outcome = lesson.compute(lesson.apply(lesson.start(), {"reduced": True}))
    design = device_design(lesson, outcome)
    gap = design.gap()
    assert design.routine.kind == "reduced-order observer" and gap is not None and gap < 0.02
    for flags in (["-O0"], ["-O3"]):
        folder = write_files(tmp_path, device_files(lesson, outcome, "token", "c"))
        assert run_c(folder, flags).endswith("every bit as in the lab's Python.")


@pytest.mark.parametrize("gate", [None, 0.99])
def test_recursive_filter_takes_missing_readings_and_outliers_as_the_engine_does(gate: float | None) -> None:
    random = np.random.default_rng(5)
    A, C = np.array([[0.9, 0.2, 0.0], [0.0, 0.8, 0.1], [0.1, 0.0, 0.7]]), random.normal(size=(2, 3))
    B, R = random.normal(size=(3, 1)), np.array([[0.3, 0.1], [0.1, 0.2]])
    kf = KalmanFilter(A, B, C, 0.01 * np.eye(3), R, dt=0.1)
    y, u = random.normal(size=(120, 2)), random.normal(size=(120, 1))
    y[random.random((120, 2)) < 0.2] = np.nan
    y[60, 0] = 40.0
    start = Belief(np.zeros(3), np.eye(3))
    track = kf.run(start, y, u, gate=gate)
    names = (("a", "b", "c"), ("u",), ("y", "z"))
    device = Device(kalman_routine(A, B, C, kf.Q, R, (start.mean, start.covariance), 0.1, names, gate=gate))
    found = device.run(y, u, tables=("xhat", *(["rejected"] if gate else [])))
    assert np.abs(found["xhat"] - track.means).max() < 1e-12
    if gate:
        assert found["rejected"][-1, 0] >= 1
        assert np.abs(found["xhat"][60]).max() < 5


@pytest.mark.slow
@pytest.mark.parametrize("name", ["separation", "kalman", "lqg", "noise", "robust-observer", "bilinear-observer", "fault-diagnosis",
                                  "sandbox"])
def test_devices_of_random_designs_follow_the_page(name: str) -> None:
    """Each that is refused is refused in one sentence."""
    lesson, random, made = LESSONS[name], np.random.default_rng(7), 0
    for _ in range(4):
        outcome = random_design(lesson, random, device_design)
        if outcome is not None:
            made += 1
            gap = device_design(lesson, outcome).gap()
            assert gap is None or gap < SAMPLED.get(name, 1e-7), outcome.design
    assert made


@pytest.mark.slow
@pytest.mark.parametrize("case", ["pendulum", "fall"])
def test_extended_filter_gives_the_engine_estimate_and_the_same_bits_in_c(tmp_path, case: str) -> None:
    """Its sine and exponential are the step's own polynomials, so that every body agrees; the engine calls those of NumPy."""
    lesson = LESSONS["nonlinear"]
    outcome = lesson.compute(lesson.apply(lesson.start(), {"case": case}))
    gap = device_design(lesson, outcome).gap()
    assert gap is not None and gap < 1e-12
    for single in (False, True):
        folder = write_files(tmp_path, device_files(lesson, outcome, "token", "c", single=single))
        for flags in (["-O0"], ["-O3"]):
            assert run_c(folder, flags).endswith("every bit as in the lab's Python.")
    with pytest.raises(DeviceError, match="take C or MicroPython"):
        device_files(lesson, outcome, "token", "st")


def test_deck_of_the_nonlinear_lesson_is_refused_in_a_sentence() -> None:
    lesson = LESSONS["nonlinear"]
    with pytest.raises(DeviceError, match="choose the cart-pendulum"):
        device_design(lesson, lesson.compute(lesson.apply(lesson.start(), {"case": "platform"})))


def test_slopes_of_a_description_are_those_of_small_differences() -> None:
    statements = (("a", "lab_sin(p) * q + 2.0 / (q * q + 1.0)"), ("b", "lab_exp(-a) - lab_cos(p * q)"), ("c", "sqrt(b * b + a * k)"))
    full = with_slopes(statements, ("p", "q"))

    def value(p: float, q: float) -> dict[str, float]:
        names = {"p": p, "q": q, "k": 3.0, "lab_sin": math.sin, "lab_cos": math.cos, "lab_exp": math.exp, "sqrt": math.sqrt}
        for name, words in full:
            names[name] = eval(words, {}, names)
        return names  # type: ignore[return-value]

    here = value(0.7, 1.3)
    for name in ("a", "b", "c"):
        for k, variable in enumerate(("p", "q")):
            step = [1e-6 * (k == 0), 1e-6 * (k == 1)]
            slope = (value(0.7 + step[0], 1.3 + step[1])[name] - value(0.7 - step[0], 1.3 - step[1])[name]) / 2e-6
            assert abs(here[slope_of(full, name, variable)] - slope) < 1e-8
