"""What the engine says of its own answers is right within a factor of ten: a sample of the table of certificates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from certificates import LAWS, breach

from observer_lab.engine import observer_gain, place
from observer_lab.engine.design import polynomial_roots


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_a_certificate_is_right_within_ten(law: str) -> None:
    broken = {seed: wrong for seed in range(3) if (wrong := breach(law, (7, seed)))}
    assert not broken


def test_the_error_of_a_double_pole_nearly_out_of_reach_is_what_it_is() -> None:
    """Two modes 1e-11 apart: double precision finds poles 1.4 away, the gain puts them 8e-5 away."""
    found = place(np.diag([-1.0, -1.0 - 1e-11]), np.ones((2, 1)), [-2, -3])
    assert 1e-6 < found.error < 1e-3


def test_a_gain_that_is_exact_has_no_error() -> None:
    """Multiplicity is data: a gain in whole numbers puts both poles where they were asked for, and says so."""
    found = observer_gain([[0, 1], [0, 0]], [[1, 0]], [-6, -6])
    np.testing.assert_array_equal(np.round(found.gain, 12), [[12], [36]])
    assert found.error < 1e-6


MULTIPLE = ([-1.0] * 10, [-1.1] * 3 + [3.7] * 2, [-2 + 1j, -2 - 1j] * 3, [-1 + 1j, -1 - 1j] * 4 + [-1.2] * 3, [0.0, 0.0, -3.0])


@pytest.mark.parametrize("given", MULTIPLE)
def test_a_multiple_root_is_one_root(given: list[complex]) -> None:
    found = polynomial_roots(np.poly(given).real)
    assert len(np.unique(found)) == len(set(given))
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.array(given, dtype=complex)), rtol=1e-12)


def test_roots_that_the_data_tell_apart_stay_apart() -> None:
    given = np.array([-1.0, -1.0001, -2.0, -2.0 - 1e-4])
    found = polynomial_roots(np.poly(given))
    assert len(np.unique(found)) == 4
    np.testing.assert_allclose(np.sort(found.real), np.sort(given), rtol=1e-7)


def test_stationary_covariances_come_from_one_room() -> None:
    """SciPy's direct solver loses six digits on loops with gains of a hundred; a Newton step, judged by what it leaves, may use it."""
    root = Path(__file__).resolve().parents[2]
    users = {p.relative_to(root).as_posix() for folder in ("app", "lessons") for p in (root / folder).rglob("*.py")
             if "solve_discrete_lyapunov(" in p.read_text(encoding="utf-8")}
    assert users <= {"app/engine/systems/lyapunov.py", "app/engine/systems/stability.py"}  # `lyap` of any Q, and a judged Newton step
