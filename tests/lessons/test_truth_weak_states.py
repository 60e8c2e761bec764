"""Both bounds of a truncation, by frequency responses of scipy over random designs; none of equal values where they are cut apart."""

from __future__ import annotations

import numpy as np
import pytest
from attack import outcome_of, random_designs
from scipy import signal

from observer_lab.lessons.weak_states.lesson import LESSON
from observer_lab.lessons.weak_states.study import sharp_bound


def test_a_resonance_reaches_the_sharp_bound_and_half_of_the_other() -> None:
    for g, c, k in ((2.0, 0.4, 20.0), (7.0, 2.5, 89.0)):
        _, height = signal.freqresp(signal.lti([g, 0], [1, c, k]), [np.sqrt(k)])
        values = np.array([g / (2 * c)] * 2)
        assert sharp_bound(values, 0) == pytest.approx(abs(height[0])) and 2 * values.sum() == pytest.approx(2 * abs(height[0]))
        assert sharp_bound(values, 1) is None and sharp_bound(values, 2) == 0


def test_values_count_once_each() -> None:
    values = np.array([5.0, 3.0, 3.0, 1.0, 0.5, 0.5, 0.5])
    assert [sharp_bound(values, r) for r in range(8)] == [19.0, 9.0, None, 3.0, 1.0, None, None, 0.0]


@pytest.mark.slow
def test_the_error_keeps_below_both_bounds() -> None:
    for design in random_designs(LESSON, 12, 34):
        for order in (2, 4, 5, 6, 8, 9):
            outcome = outcome_of(LESSON, LESSON.apply(design, {"order": order}))
            if outcome is None:
                continue
            s, c = outcome.study.system, outcome.study.cut
            f = np.unique(np.concatenate([np.geomspace(1e-3, 1e3, 400), *(m.frequency * (1 + m.damping * np.linspace(-2, 2, 81))
                                                                          for m in s.motions)]))
            error = 0.0
            for w in 2 * np.pi * f:
                gap = (s.plant.C @ np.linalg.solve(1j * w * np.eye(10) - s.plant.A, s.plant.B)
                       - c.model.C @ np.linalg.solve(1j * w * np.eye(order) - c.model.A, c.model.B))
                error = max(error, float(np.linalg.norm(gap, 2)))
            assert error <= c.bound * (1 + 1e-5) + 1e-8
            assert c.sharp is None or error <= c.sharp * (1 + 2e-3) + 1e-8
            assert (c.sharp is None) == (s.hankel[order - 1] - s.hankel[order] <= 1e-3 * s.hankel[order - 1])
