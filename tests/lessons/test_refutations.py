"""The numbers in the refutations of wrong predictions, computed again by the lessons."""

from __future__ import annotations

import re
from typing import Any

from laws import each

from observer_lab.course.guiding.predictions import LETTERS
from observer_lab.lessons import LESSONS
from observer_lab.text import languages

DOYLE = {"case": "doyle", "q": 5.0, "sigma": 5.0}
QUIET = {"sensor": 1e-14}
TOLD = {**QUIET, "v": 1e-14}
HELD = {"input": "step", "amplitude": 3.0}
# lesson, letter of the option, knobs, metric, and how it is printed
PRINTED: tuple[tuple[str, str, dict[str, Any], str, str], ...] = (
    ("virtual-sensor", "C", {}, "slowest_copy", "-0.0881"),
    ("virtual-sensor", "C", {}, "slowest_observer", "-1.6"),
    ("error-dynamics", "A", {"amplitude": 2.0}, "state_moved", "4 m"),
    ("error-dynamics", "C", {}, "settled_after", "2.85 s"),
    ("error-dynamics", "C", {"input": "none"}, "settled_after", "2.85 s"),
    ("observability", "A", {}, "rank", "2"),
    ("observability", "C", {"left": 0.01}, "weakest", "0.0047"),
    ("separation", "C", {}, "slowest_observer", "−9"),
    ("separation", "C", {"controller_poles": (-12 - 10j, -12 + 10j, -15.5 - 8j, -15.5 + 8j, -14 - 6j, -14 + 6j)},
     "slowest_observer", "−9"),
    ("duality", "A", {}, "L1", "1.1"),
    ("duality", "A", {}, "L2", "−0.27"),
    ("hidden-modes", "B", {"observer_part": (-8 - 1j, -8 + 1j)}, "error_rate", "0.5"),
    ("hidden-modes", "D", {}, "hidden_rate", "0.5"),
    ("noise", "B", {}, "velocity_rms", "0.73"),
    ("noise", "B", {"speed": 10.0}, "velocity_rms", "2.12 m/s"),
    ("noise", "C", {}, "settled_after", "0.46 s"),
    ("noise", "C", {"speed": 10.0}, "settled_after", "0.23 s"),
    ("noise", "D", {}, "largest_gain", "240"),
    ("noise", "D", {"speed": 10.0}, "largest_gain", "983"),
    ("kalman", "A", {"r": 1.0}, "nis_mean", "5.90"),
    ("kalman", "A", {"q": 1.0}, "nis_mean", "2.41"),
    ("kalman", "A", {}, "nis_mean", "3.79"),
    ("kalman", "B", {}, "nees_mean", "61"),
    ("kalman", "D", {"q": 1.0, "r": 1.0}, "nees_mean", "6.09"),
    ("kalman", "D", {"q": 1.0, "r": 1.0}, "nis_mean", "3.90"),
    ("lqg", "A", DOYLE, "phase_deg", "2.8°"),
    ("lqg", "C", DOYLE, "phase_deg", "2.8°"),
    ("decoupling", "A", {}, "rotation", "88 dB"),
    ("decoupling", "B", {"lower": 5.0}, "rotation", "20 dB"),
    ("decoupling", "D", {"pitch": True}, "rotation", "105 dB"),
    ("weak-states", "A", {}, "sigma5", "43"),
    ("weak-states", "C", {}, "sigma7", "0.054"),
    ("weak-states", "D", {"pair": "5"}, "frequency", "30.2 Hz"),
    ("showdown", "B", QUIET, "lqe_vertical_band_db", "23 dB"),
    ("showdown", "B", QUIET, "siso_vertical_band_db", "50"),
    ("showdown", "B", TOLD, "lqe_vertical_band_db", "58 dB"),
    ("showdown", "C", QUIET, "decoupled_rotation_band_db", "19 dB"),
    ("showdown", "C", QUIET, "lqe_rotation_band_db", "22"),
    ("showdown", "C", TOLD, "decoupled_rotation_band_db", "37"),
    ("showdown", "C", TOLD, "lqe_rotation_band_db", "52"),
    ("showdown", "D", {}, "siso_vertical_band_db", "21.5"),
    ("robust-observer", "A", {"pole": (-10 + 0j,)}, "late_error", "1.40"),
    ("robust-observer", "B", {"pole": (-5 + 0j,)}, "late_error", "0.94"),
    ("robust-observer", "B", {"pole": (-5 / 3 + 0j,)}, "late_error", "0.43"),
    ("bilinear-observer", "A", HELD, "settled_after", "0.135 s"),
    ("bilinear-observer", "A", {"input": "none"}, "settled_after", "0.135 s"),
    ("bilinear-observer", "B", {**HELD, "gain": "typed", "l4": 8.0}, "late_error", "228"),
    ("fault-diagnosis", "B", {}, "delay", "0.46 s"),
    ("fault-diagnosis", "B", {"place": "HR"}, "delay", "0.48 s"),
    ("network", "A", {"loss": 0.75}, "growth", "1.08"),
    ("network", "B", {}, "growth", "0.43"),
    ("network", "B", {}, "lower", "0.90"),
    ("network", "B", {}, "upper", "1.59"),
    ("record", "A", {}, "suggested", "2"),
    ("record", "C", {}, "edge", "0.34"),
    ("record", "C", {}, "suggested", "2"),
    ("record", "D", {}, "last_value", "0.93"),
    ("record", "D", {}, "edge", "0.34"),
    ("arm", "C", {}, "load_belief", "1.50"),
    ("arm", "D", {}, "slowest_observer", "−12"),
)


@each("name, letter, values, metric, printed", PRINTED)
def test_a_number_in_a_refutation_is_what_the_lesson_gives(
        name: str, letter: str, values: dict[str, Any], metric: str, printed: str) -> None:
    lesson, figure = LESSONS[name], printed.split()[0].rstrip("°")
    for language in languages():
        words = lesson.words[language].refutations[LETTERS.index(letter)]
        assert re.search(rf"(?<![\d.]){re.escape(figure)}(?!\d|\.\d)", words), words
    found = lesson.compute(lesson.apply(lesson.start(), values)).metrics[metric]
    digits = len(figure.partition(".")[2])
    assert abs(found - float(figure.replace("−", "-"))) <= 0.5001 * 10.0 ** -digits, found
