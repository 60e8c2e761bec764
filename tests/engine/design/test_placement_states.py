"""Placement in any units of the states: one feedback, whatever each state is measured in."""

from __future__ import annotations

import numpy as np
import pytest

from observer_lab.engine import observer_gain, place

DECADES = (-9.0, -6.0, -3.0, -0.3, 0.0, 0.7, 3.0, 6.0, 9.0)


def two_masses(second: float, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities of two masses, 1 kg and `second` kg, on a spring; a force on each."""
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2:, :2] = stiffness * np.array([[-1, 1], [1 / second, -1 / second]])
    A[2:, 2:] = 0.1 * np.array([[-1, 1], [1 / second, -1 / second]])
    return A, np.vstack([np.zeros((2, 2)), np.diag([1.0, 1 / second])])


@pytest.mark.parametrize("poles", [[-1, -2, -3, -4], [-10, -11, -12, -13], [-2 + 2j, -2 - 2j, -3 + 1j, -3 - 1j]])
@pytest.mark.parametrize(("second", "stiffness"), [(1.0, 100.0), (0.1, 10.0)])
def test_the_feedback_of_two_masses_is_the_same_in_any_unit(second: float, stiffness: float, poles: list[complex]) -> None:
    A, B = two_masses(second, stiffness)
    own = place(A, B, poles).gain
    for decade in DECADES:
        for states in ([1, 3], [0], [1], [2], [0, 1, 2, 3]):
            unit = np.ones(4)
            unit[states] = 10.0**decade
            force = np.array([10.0**decade, 1.0])
            found = place(A * unit / unit[:, None], B * force / unit[:, None], poles).gain * force[:, None] / unit
            np.testing.assert_allclose(found, own, rtol=1e-6, atol=1e-6 * np.abs(own).max())
            turned = observer_gain((A * unit / unit[:, None]).T, (B / unit[:, None]).T, poles).gain
            np.testing.assert_allclose(turned.T / unit, own, rtol=1e-6, atol=1e-6 * np.abs(own).max())


def test_sizes_of_states_say_what_counts_as_alike() -> None:
    A, B = two_masses(0.1, 10.0)
    unit = np.array([1.0, 1e3, 1.0, 1e3])
    own = place(A, B, [-4, -5, -6, -7], sizes=np.ones(4)).gain
    same = place(A * unit / unit[:, None], B / unit[:, None], [-4, -5, -6, -7], sizes=1 / unit).gain / unit
    np.testing.assert_allclose(same, own, rtol=1e-6, atol=1e-6 * np.abs(own).max())
    with pytest.raises(ValueError, match="one for each state"):
        place(A, B, [-4, -5, -6, -7], sizes=[1.0, 0.0, 1.0, 1.0])
