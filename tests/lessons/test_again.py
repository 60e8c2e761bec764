"""Second predictions: every lesson has one, its knob opens it, a run gives the right option, and every number in it is a run's."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from laws import each
from lesson_checks import every_lesson

from observer_lab.course.guiding.predictions import LETTERS
from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

Metrics = Mapping[str, float]


def among(*options: bool) -> int:
    """The one option that is true."""
    assert sum(options) == 1, options
    return options.index(True)


def near(a: float, b: float, share: float = 0.02) -> bool:
    """The same to a few per cent."""
    return abs(a - b) <= share * abs(b) + 1e-12


def union_kept(m: Metrics, board: str) -> bool:
    """Whether the poles of a board of the separation lesson are poles of the loop."""
    poles = run("separation", LESSONS["separation"].again.trial).poles
    return all(abs(poles["loop"] - pole).min() < 1e-3 for pole in poles[board])


def gains(name: str, values: Mapping[str, Any]) -> Any:
    return run(name, values).gains


def bilinear(now: float, before: float) -> int:
    return among(near(now, before / 2, 0.1), 1.02 * before < now < 1.5 * before, near(now, before))


def fault(now: float, before: float) -> int:
    return among(0 < now < before, near(now, 4 * before, 0.2), near(now, before))


# by lesson: of the options in their order, which the numbers at the start and at the trial bear out
SAYS: dict[str, Callable[[Metrics, Metrics], int]] = {
    "virtual-sensor": lambda a, b: among(near(b["largest_guess"], a["largest_guess"]), b["largest_guess"] > 90, b["largest_guess"] <= 45),
    "error-dynamics": lambda a, b: among(*(near(b["settled_after"], t) for t in (5.7, 2.85 + 0.46, 2.85))),
    "observability": lambda a, b: among(near(b["longest"], a["longest"], 1e-6), near(b["longest"], 0.1), 0.11 < b["longest"] < 0.9),
    "separation": lambda a, b: among(union_kept(b, "controller"), union_kept(b, "observer"), b["union_error"] < 1e-9,
                                     not union_kept(b, "controller") and not union_kept(b, "observer")),
    "duality": lambda a, b: among(*(lambda k, o: (not k and not o, k and o, k and not o))(
        near(*(float(gains("duality", v)["K"][0, 0]) for v in ({}, {"sensor": 90.0})), 1e-9), near(b["L1"], a["L1"], 1e-9))),
    "hidden-modes": lambda a, b: among(b["state_end"] < 0.05, 0.05 < b["state_end"] < 0.9 * a["state_end"],
                                       b["state_end"] > 1.1 * a["state_end"], near(b["state_end"], a["state_end"], 1e-3)),
    "saturation": lambda a, b: among(False, not b["comes_home"] and b["stopped_at"] < a["stopped_at"], bool(b["comes_home"])),
    "noise": lambda a, b: among(near(b["kalman_speed"], a["kalman_speed"]), near(b["kalman_speed"], a["kalman_speed"] / 16),
                                near(b["kalman_speed"], a["kalman_speed"] / 2, 0.1)),
    "kalman": lambda a, b: among(b["nees_mean"] < 3, b["nees_mean"] > 61, 5 < b["nees_mean"] < 7),
    "lqg": lambda a, b: among(near(b["J"], 750), b["J"] < 740, 760 < b["J"] < 900, near(b["J"] / 750, 90)),
    "decoupling": lambda a, b: among(b["rotation"] > 89, near(b["rotation"], 88), 75 < b["rotation"] < 86, b["rotation"] < 5),
    "weak-states": lambda a, b: among(*(near(b["error"], share * eight()["error"], 1e-3) for share in (1, 0.5)), b["error"] < 1e-6),
    "showdown": lambda a, b: among(b["lqe_rotation_band_db"] < a["lqe_rotation_band_db"], b["lqe_rotation_band_db"] > a[
        "lqe_rotation_band_db"] and b["lqe_rotation_rms"] > a["lqe_rotation_rms"], not b["lqe_stable"]),
    "nonlinear": lambda a, b: among(b["nees_kf"] < 0.9 * a["nees_kf"], near(b["nees_kf"], a["nees_kf"], 0.1),
                                    b["nees_kf"] > 10 * a["nees_kf"]),
    "robust-observer": lambda a, b: among(b["late_error"] > 1.1 * a["late_error"], 0.01 < b["late_error"] < 0.9 * a["late_error"],
                                          b["late_error"] < 1e-6),
    "bilinear-observer": lambda a, b: bilinear(b["half_error"], metrics("bilinear-observer", form="filtered")["half_error"]),
    "fault-diagnosis": lambda a, b: fault(b["delay"], metrics("fault-diagnosis", bias=1.5)["delay"]),
    "network": lambda a, b: among(near(b["loop_radius"], a["loop_radius"]), b["loop_radius"] > 1,
                                  near(b["loop_radius"], 0.95, 0.01) and b["separation_meter"] < 1e-6),
    "sandbox": lambda a, b: among(b["nis_mean"] < 0.01, near(b["nis_mean"], a["nis_mean"] / 4, 0.05), b["nis_mean"] > 2),
    "arm": lambda a, b: among(abs(b["load_error"]) > 0.01, b["angle_belief"] > 0.01, b["angle_error"] < 0.1,
                              abs(b["load_error"]) < 1e-3 and b["angle_error"] > 3),
    "record": lambda a, b: among(b["mean_nis"] > b["nis_high"], near(b["mean_nis"], a["mean_nis"], 0.1), b["mean_nis"] < 0.5),
}
QUIETER, SIX, DOYLE = {"sensor": 0.1}, {"order": 6}, {"case": "doyle"}
# lesson, knobs (None: the trial), metric, and how it is printed
PRINTED: tuple[tuple[str, dict[str, Any] | None, str, str], ...] = (
    ("virtual-sensor", None, "largest_guess", "92.7"), ("virtual-sensor", {}, "largest_guess", "33.8"),
    ("virtual-sensor", {}, "known_after", "2.76"), ("virtual-sensor", None, "known_after", "2.01"),
    ("virtual-sensor", {}, "largest_gain", "4.66"), ("virtual-sensor", None, "largest_gain", "36"),
    ("error-dynamics", {}, "settled_after", "2.85"), ("error-dynamics", None, "settled_after", "2.85"),
    ("observability", None, "longest", "1.0"), ("observability", {"right_on": True}, "longest", "0.76"),
    ("observability", {"right_on": True, "noise": 0.003}, "longest", "0.12"), ("observability", None, "known", "2"),
    ("separation", None, "slowest_loop", "−2.79"),
    ("duality", {}, "L1", "1.1"), ("duality", {}, "L2", "−0.27"), ("duality", None, "L1", "−0.28"), ("duality", None, "L2", "1.1"),
    ("hidden-modes", {}, "state_end", "3.45"), ("hidden-modes", None, "state_end", "3.45"),
    ("saturation", None, "stopped_at", "0.68"), ("saturation", {}, "stopped_at", "0.76"),
    ("noise", {}, "kalman_speed", "3.17"), ("noise", None, "kalman_speed", "1.64"),
    ("noise", {}, "least_velocity_rms", "0.117"), ("noise", None, "least_velocity_rms", "0.145"),
    ("kalman", {}, "nees_mean", "61"), ("kalman", None, "nees_mean", "2.07"), ("kalman", None, "nis_mean", "0.96"),
    ("lqg", DOYLE, "J", "750"), ("lqg", DOYLE, "gain_high", "1.04"), ("lqg", None, "gain_high", "3.3"),
    ("decoupling", {}, "rotation", "88"), ("decoupling", None, "rotation", "3"), ("decoupling", None, "horizontal", "105"),
    ("decoupling", {}, "J", "20.7"), ("decoupling", None, "J", "17.7"), ("decoupling", None, "b", "0.09"),
    ("weak-states", {"order": 8}, "error_at", "30.2"),
    ("weak-states", SIX, "error", "0.108"), ("weak-states", {"order": 7}, "error", "0.108"),
    ("showdown", {}, "lqe_rotation_band_db", "13"), ("showdown", None, "lqe_rotation_band_db", "21.5"),
    ("showdown", {}, "lqe_rotation_rms", "2.54"), ("showdown", None, "lqe_rotation_rms", "3.04"),
    ("nonlinear", QUIETER, "nees_ekf", "54"),
    ("robust-observer", {}, "late_error", "0.94"), ("robust-observer", None, "late_error", "1.35"),
    ("robust-observer", {"c": -0.05}, "late_error", "3.5"), ("robust-observer", {}, "worst_gain", "3.8"),
    ("robust-observer", None, "worst_gain", "1.9"),
    ("bilinear-observer", {"form": "filtered"}, "half_error", "0.097"), ("bilinear-observer", None, "half_error", "0.117"),
    ("bilinear-observer", {}, "pi", "9.29"), ("bilinear-observer", None, "pi", "21.1"),
    ("fault-diagnosis", {"bias": 1.5}, "delay", "4.34"), ("fault-diagnosis", None, "delay", "1.88"),
    ("fault-diagnosis", {}, "delay", "0.46"), ("fault-diagnosis", {"window": 100}, "delay", "0.58"),
    ("network", {}, "loop_radius", "0.41"), ("network", None, "loop_radius", "0.95"), ("network", {"delay": 2}, "loop_radius", "1.14"),
    ("network", {"delay": 1, "told": "ahead"}, "loop_radius", "0.41"),
    ("sandbox", {}, "nis_mean", "1.66"), ("sandbox", None, "nis_mean", "0.41"), ("sandbox", {"belief": 0.001}, "nis_mean", "9.1"),
    ("record", {}, "mean_nis", "0.88"), ("record", None, "mean_nis", "0.26"),
    ("arm", None, "load_belief", "1.50"), ("arm", None, "angle_error", "7.1"), ("arm", None, "found_after", "0.42"),
    ("arm", {"load_state": False}, "angle_error", "15.5"), ("arm", {"load_state": False}, "angle_belief", "3.0"),
)


@lru_cache(maxsize=128)
def _computed(name: str, values: tuple[tuple[str, Any], ...]) -> Any:
    lesson = LESSONS[name]
    return lesson.compute(lesson.apply(lesson.start(), dict(values)))


def run(name: str, values: Mapping[str, Any]) -> Any:
    return _computed(name, tuple(values.items()))


def metrics(name: str, **values: Any) -> Metrics:
    return run(name, values).metrics


def eight() -> Metrics:
    return metrics("weak-states", order=8)


@every_lesson
def test_a_second_prediction_opens_with_its_knob_and_veils_figures_that_exist(lesson: Lesson) -> None:
    again, start = lesson.again, lesson.start()
    assert again is not None and not again.touched(start, start)
    trial = lesson.apply(start, again.trial)
    assert again.touched(start, trial)
    shown = {figure.id for figure in lesson.figures(run(lesson.id, again.trial))}
    assert again.figures and set(again.figures) <= shown
    assert all(lesson.shown(lesson.knob(name), trial) for name in again.knobs)


@each("name", LESSONS)
def test_a_run_gives_the_right_option(name: str) -> None:
    again = LESSONS[name].again
    assert again is not None
    assert SAYS[name](run(name, {}).metrics, run(name, again.trial).metrics) == again.answer


def test_the_right_letters_are_spread_evenly() -> None:
    found = Counter(LETTERS[lesson.again.answer] for lesson in LESSONS.values() if lesson.again is not None)
    assert all(found[letter] - len(LESSONS) // 4 in (0, 1) for letter in "ABCD"), found


@each("name, values, metric, printed", PRINTED)
def test_a_number_in_a_second_prediction_is_what_the_lesson_gives(
        name: str, values: dict[str, Any] | None, metric: str, printed: str) -> None:
    lesson = LESSONS[name]
    assert lesson.again is not None
    for language in languages():
        asked = lesson.words[language].again
        words = " ".join((asked.question, *asked.options, *asked.refutations, asked.reveal))
        assert re.search(rf"(?<![\d.]){re.escape(printed)}(?!\d|\.\d)", words), (language, printed)
    found = run(name, lesson.again.trial if values is None else values).metrics[metric]
    digits = len(printed.partition(".")[2])
    assert abs(found - float(printed.replace("−", "-"))) <= 0.5001 * 10.0 ** -digits, found


def test_numbers_that_are_rounded_to_powers_or_shares_are_right() -> None:
    right = {
        "lqg, J": abs(metrics("lqg", case="doyle", recovery=4.0)["J"] / 68500 - 1) < 1e-3,
        "lqg, share": abs(metrics("lqg", case="doyle", recovery=4.0)["sensor_share"] - 0.987) < 5e-4,
        "separation at 10 %": abs(metrics("separation", stiffness_error=10.0)["union_error"] - 0.064) < 5e-4,
        "separation at 30 %": abs(metrics("separation", stiffness_error=30.0)["union_error"] - 0.27) < 5e-3,
        "weak states, both": all(abs(metrics("weak-states", order=n)["error"] / 1.77e-4 - 1) < 3e-3 for n in (8, 9)),
        "weak states, bound": near(metrics("weak-states", order=9)["bound"], metrics("weak-states", order=9)["error"], 1e-3),
        "nonlinear, start": 6.5e6 < metrics("nonlinear")["nees_kf"] < 7.5e6,
        "nonlinear, trial": 1.5e8 < metrics("nonlinear", sensor=0.1)["nees_kf"] < 2.5e8,
        "nonlinear, EKF": abs(metrics("nonlinear")["nees_ekf"] / 4000 - 1) < 0.01,
        "saturation, 2° and 3°": all(metrics("saturation", error0=e)["comes_home"] for e in (2.0, 3.0)),
        "saturation, 3° unclipped": metrics("saturation", error0=3.0)["clipped_for"] == 0,
        "saturation, told": metrics("saturation", error0=0.0, fed="applied")["comes_home"] == 1,
    }
    assert not [name for name, holds in right.items() if not holds]
