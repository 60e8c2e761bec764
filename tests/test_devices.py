"""Designs as code for devices: one order of operations, the same bits in Python and in C, and the page's own estimate."""

import re

import numpy as np
import pytest
from all_plants import random_plant
from device_bodies import SANITIZERS, run_c, write_files
from laws import each

from observer_lab.cli import main
from observer_lab.devices import Device, DeviceError, StepError, check_step, design_of_run, observer_routine
from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.export.devices.folders import device_design, device_files, zip_of
from observer_lab.export.devices.words import comment_word, identifier
from observer_lab.lessons import LESSONS
from observer_lab.text import same

FIRST = "separation"
PLANT = Plant([[0.9, 0.1], [-0.2, 0.8]], [[0.0], [0.1]], [[1.0, 0.0]], [[0.5]], 0.1)
L = np.array([[0.4], [0.1]])


def outcome_of(name: str, **values: object):
    lesson = LESSONS[name]
    return lesson, lesson.compute(lesson.apply(lesson.start(), values))


@pytest.mark.parametrize("single", [False, True])
def test_first_lesson_gives_the_same_bits_in_c_at_every_optimisation(tmp_path, single: bool) -> None:
    lesson, outcome = outcome_of(FIRST, limited=True, u_max=0.5)
    folder = write_files(tmp_path, device_files(lesson, outcome, "token", "c", single=single))
    for flags in (["-O0"], ["-O3"], SANITIZERS):
        assert run_c(folder, flags) == "400 samples: every bit as in the lab's Python."


def test_test_program_reports_a_number_that_is_off_by_its_last_bit(tmp_path) -> None:
    lesson, outcome = outcome_of(FIRST)
    files = dict(device_files(lesson, outcome, "token", "c"))
    digit = re.search(r"page_xhat\[\d+\] = \{.*?0x1\.\w{12}(\w)p", str(files["lab_test.c"]), re.DOTALL)
    assert digit is not None
    at, other = digit.start(1), "0" if digit[1] != "0" else "1"
    files["lab_test.c"] = f"{str(files['lab_test.c'])[:at]}{other}{str(files['lab_test.c'])[at + 1:]}"
    assert run_c(write_files(tmp_path, files), ["-O2"]) == "1 numbers differ from the lab's Python."


def test_device_estimates_what_the_page_shows() -> None:
    for name in ("virtual-sensor", "error-dynamics", FIRST, "duality", "hidden-modes", "noise", "sandbox"):
        gap = device_design(*outcome_of(name)).gap()
        assert gap is not None and gap < 1e-12, name


def test_device_follows_the_equations_of_the_observer() -> None:
    """x̂⁺ = A x̂ + B u + L (y − C x̂ − D u) in NumPy, which sums in its own order; a missing reading corrects nothing."""
    device = Device(observer_routine(PLANT, None, L, [1.0, -1.0], same("")))
    random, xhat = np.random.default_rng(3), np.array([1.0, -1.0])
    for k in range(50):
        y, u = random.normal(size=1), random.normal(size=1)
        lost = k % 7 == 3
        device.step([np.nan] if lost else y, u)
        assert np.allclose(device.read("xhat"), xhat, rtol=1e-13, atol=1e-14)
        innovation = np.zeros(1) if lost else y - PLANT.C @ xhat - PLANT.D @ u
        xhat = PLANT.A @ xhat + PLANT.B @ u + L @ innovation


@each("applied", [True, False])
def test_device_clips_and_tells_its_observer(applied: bool) -> None:
    plant = Plant(PLANT.A, PLANT.B, PLANT.C, None, 0.1)
    K = np.array([[5.0, 5.0]])
    device = Device(observer_routine(plant, K, L, [1.0, 1.0], same(""), limits=(np.array([-0.5]), np.array([np.inf])), applied=applied))
    assert device.step([1.0]) == [-0.5]
    told = -0.5 if applied else -10.0
    device.step([0.0])
    assert np.allclose(device.read("xhat"), plant.A @ [1.0, 1.0] + plant.B[:, 0] * told, rtol=1e-13)


def test_sampling_says_what_it_costs_and_refuses_where_it_breaks() -> None:
    plant = Plant([[0.0, 1.0], [4.0, 0.0]], [[0.0], [1.0]], [[1.0, 0.0]])
    run = simulate(Scenario(plant, [[12.0, 5.0]], [[10.0], [40.0]], x0=[0.1, 0.0], horizon=4.0, dt=0.01))
    slow = design_of_run(run, 0.05)
    assert slow.routine.period == 0.05 and len(slow.y) == 81
    assert "Disk margin" in str(slow.loss[1]) and float(str(slow.loss[1]).split()[-1][:-1]) < float(str(slow.loss[1]).split()[3][:-1])
    with pytest.raises(DeviceError, match="unstable: its largest pole has modulus"):
        design_of_run(run, 1.0)
    with pytest.raises(DeviceError, match=r"choose 0\.02 s instead of 0\.023 s"):
        design_of_run(run, 0.023)
    with pytest.raises(DeviceError, match="fewer than two samples"):
        design_of_run(run, 4.0)


def test_what_no_device_can_compute_is_refused_in_one_sentence() -> None:
    held = Scenario(PLANT, [[1.0, 0.0]], L, x0=[1.0, 0.0], horizon=1.0, dt=0.1, state_feedback=True)
    with pytest.raises(DeviceError, match="feeds back the true state"):
        design_of_run(simulate(held))
    with pytest.raises(DeviceError, match="no observer gain and no feedback"):
        design_of_run(simulate(Scenario(PLANT, horizon=1.0, dt=0.1)))
    with pytest.raises(DeviceError, match=r"sampled every 0\.1 s already"):
        design_of_run(simulate(Scenario(PLANT, None, L, horizon=1.0, dt=0.1)), 0.2)


def test_a_filter_that_rounding_stops_is_refused_in_one_sentence() -> None:
    """A plant whose numbers span fourteen decades: a variance of its filter becomes negative by rounding."""
    own = LESSONS["kalman"].fit(random_plant((43, 9)))
    with pytest.raises(DeviceError, match="other units"):
        device_files(own, own.compute(own.start()), "token", "c")


@each("source", ["x[0] = x[0] ** 2.0", "import os", "x[0] = open('a')", "while x[0] < 1.0:\n    x[0] = 1.0", "x[0] = 1", "x[k] = 1.0",
                 "x[0] = s", "n = 1.0", "x[0] += 1.0", "x[0] = x.a", "z[0] = 1.0", "for i in x:\n    s = 1.0", "x[0] = sqrt(1.0, 2.0)",
                 "x[0] = x[0] // 2.0", "if x[0]:\n    s = 1.0", "def f(a):\n    b = a", "x[0] = lambda: 1"])
def test_step_language_takes_nothing_else(source: str) -> None:
    with pytest.raises(StepError, match=r"^line \d"):
        check_step(source, {"n": 2}, {"x": 2})


def test_names_never_end_a_comment_and_become_identifiers() -> None:
    assert comment_word("a */ #include <x>\n") == "a __ _include _x__" and comment_word("*/") == "__" and comment_word("") == "unnamed"
    taken: set[str] = set()
    assert [identifier(word, taken) for word in ("θ 1", "2x", "a-b", "A b", "")] == ["s_1", "s_2x", "a_b", "A_b_2", "signal"]


def test_command_line_writes_a_folder_and_says_what_is_wrong(tmp_path, capsys) -> None:
    folder = tmp_path / "code"
    assert main(["export", "noise", "--to", "c", "--ts", "0.024", "--float", "-o", str(folder)]) == 0
    assert sorted(each.name for each in folder.iterdir()) == ["Makefile", "README.md", "lab.c", "lab.h", "lab_test.c"]
    assert "typedef float lab_real;" in (folder / "lab.h").read_text() and run_c(folder, ["-O2"]).endswith("as in the lab's Python.")
    capsys.readouterr()
    for words, said in ((["noise", "--to", "c", "--ts", "nan"], "positive number of seconds"),
                        (["observability", "--to", "c"], "no observer"),
                        (["noise", "--to", "json", "--float"], "has none of them")):
        assert main(["export", *words, "-o", str(tmp_path / "x")]) == 2
        assert said in capsys.readouterr().err


def test_zip_holds_the_folder_and_is_the_same_every_time() -> None:
    lesson, outcome = outcome_of("noise")
    files = device_files(lesson, outcome, "token", "c")
    assert zip_of("noise-c", files) == zip_of("noise-c", device_files(lesson, outcome, "token", "c"))
