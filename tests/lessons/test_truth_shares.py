"""Per cent, σ and bias: nothing is called whole, settled or biased that is not."""

from __future__ import annotations

import re

import numpy as np
import pytest
from attack import single_moves
from claim_trials import spoken
from lesson_checks import every_lesson
from scipy.optimize import brentq
from scipy.stats import chi2

from observer_lab.course.figures.claims import claims_in
from observer_lab.course.lesson import Lesson
from observer_lab.lessons.kalman.lesson import LESSON as KALMAN
from observer_lab.lessons.noise.lesson import LESSON as NOISE
from observer_lab.lessons.sandbox.lesson import LESSON as SANDBOX
from observer_lab.lessons.toolkit.latex import percent
from observer_lab.lessons.virtual_sensor.lesson import LESSON as CORE

ROUNDED = re.compile(r"\{(\w+):\.0f\} ?%")


@pytest.mark.parametrize(("share", "said"), [(0.995, "99.5"), (1.0, "100"), (0.9996, "more than 99.9"), (0.0, "0"), (1e-5, "less than 0.1"),
                                             (0.5, "50"), (0.0123, "1.23")])
def test_all_is_said_of_all_and_none_of_none(share: float, said: str) -> None:
    assert percent(share)("en") == said


@pytest.mark.slow
@every_lesson
def test_no_share_is_rounded_to_all_or_to_nothing(lesson: Lesson) -> None:
    start = lesson.start()
    moves = list(single_moves(lesson))
    for k in np.random.default_rng(lesson.number).permutation(len(moves))[:5]:
        for _, words in spoken(lesson, lesson.apply(start, dict(moves[k]))):
            for message in claims_in(words):
                for place in ROUNDED.findall(message.id):
                    value = dict(message.values)[place]
                    assert not isinstance(value, float) or not (99.5 <= value < 100 - 1e-9 or 1e-9 < value <= 0.5), f"{message}: {value}"


def test_the_noise_lesson_opens_with_the_share_that_its_covariance_has() -> None:
    outcome = NOISE.compute(NOISE.start())
    share = 100 * outcome.metrics["sensor_share"]
    assert 99.0 < share < 100 and f"{share:.3g} % of" in " ".join(str(words) for _, words in spoken(NOISE, NOISE.start()))


@pytest.mark.slow
def test_no_bias_is_found_where_there_is_none() -> None:
    """Whatever the filter believes, noise without a bias is called biased in few records of a hundred."""
    for q, r in ((1.0, 0.01), (100.0, 1.0), (0.01, 1.0), (1.0, 100.0), (1.0, 1.0)):
        said = [KALMAN.compute(KALMAN.apply(KALMAN.start(), {"q": q, "r": r, "seed": seed})).live("en") for seed in range(20)]
        assert sum("a bias" in words for words in said) <= 2, (q, r)


@pytest.mark.slow
def test_under_noise_the_core_is_known_by_its_standard_deviation() -> None:
    late, outcome = [], CORE.compute(CORE.apply(CORE.start(), {"noise": 0.5}))
    for seed in range(40):
        outcome = CORE.compute(CORE.apply(CORE.start(), {"noise": 0.5, "seed": seed}))
        assert outcome.run is not None
        late.append(outcome.run.e[len(outcome.run.t) // 2::40, 0])
    caption = next(f for f in CORE.figures(outcome) if f.id == "core").caption("en")
    assert float(np.std(late)) == pytest.approx(outcome.metrics["core_sigma"], rel=0.15)
    assert f"{outcome.metrics['core_sigma']:.2g} K" in caption and "knows" not in caption


def test_an_outlier_is_said_to_be_as_rare_as_it_is() -> None:
    outcome = SANDBOX.compute(SANDBOX.start())
    figure = next(f for f in SANDBOX.figures(outcome) if f.id == "nis")
    said = figure.caption("en")
    assert "one record in twenty" not in said
    mean, expected = (float(dict(figure.caption.values)[name]) for name in ("mean", "expected"))  # type: ignore[arg-type]
    if "by chance" in said:
        share = float(said.split("with these beliefs ")[1].split(" %")[0]) / 100
        band = float(dict(figure.caption.values)["high"])  # type: ignore[arg-type]
        dof = brentq(lambda n: 2 * chi2.ppf(0.975, n) / n - band, 20.0, 1e5)  # two outputs: the band of the mean tells how many samples
        far = 2 * min(chi2.sf(dof * mean / expected, dof), chi2.cdf(dof * mean / expected, dof))
        assert share < 0.055 and abs(far - share) < 0.003
