"""Forty and more functions in other units: one state, one input, one output, time, one of each, every one, all 1e±9 away."""

from __future__ import annotations

import numpy as np
import pytest
from any_units import ALLOWED, KINDS, lost, main, plant_of
from unit_laws_more import ALL

from observer_lab.engine import dlyap, lyap
from observer_lab.engine.systems import balance

SEED = 5


def test_there_are_forty_of_them() -> None:
    assert len(ALL) >= 40 and len(KINDS) >= 5


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
def test_no_unit_costs_more_than_three_digits(part: int) -> None:
    """A fourth of the functions, each on one continuous and one sampled plant."""
    laws = list(ALL)[part::4]
    broken = [f"{law}, {kind} × {factor:g}: {digits:.1f} digits" for law in laws for k in (part, 3)
              for (kind, factor), digits in lost(law, plant_of(SEED, k), k).items() if digits > ALLOWED]
    assert not broken


@pytest.mark.whole
def test_the_table_of_units(capsys: pytest.CaptureFixture[str]) -> None:
    """Printed with -s, or by `python tests/engine/any_units.py 8`."""
    main(8, SEED)
    said = capsys.readouterr().out
    print(said)
    assert "functions, 0 of" in said


@pytest.mark.parametrize("spread", [1e6, 1e9, 1e12])
def test_lyapunov_in_unlike_units(spread: float) -> None:
    """Was wrong by a factor of 162 in units 1e6, 1, 1e-6."""
    A, Q = np.array([[-1.0, 0.3, 0.1], [0.2, -2.0, 0.4], [0.1, 0.5, -3.0]]), np.eye(3) + 0.1
    d = np.array([spread, 1.0, 1 / spread])
    for solve, M in ((lyap, A), (dlyap, A / 5)):
        moved = solve(M * d / d[:, None], Q / d / d[:, None]) * d * d[:, None]
        np.testing.assert_allclose(moved, solve(M, Q), rtol=1e-12)


@pytest.mark.parametrize("one", range(4))
def test_what_is_rounding_is_not_asked_in_the_units_given(one: int) -> None:
    """One state 1e18 away from the others, all coupled: its column looks like rounding there, and is none."""
    rng = np.random.default_rng(one)
    A, B, C = rng.standard_normal((4, 4)), rng.standard_normal((4, 1)), rng.standard_normal((1, 4))
    d = np.where(np.arange(4) == one, 1e9, 1e-9)
    found, moved = balance(A, B, C), balance(A * d / d[:, None], B / d[:, None], C * d)
    ratio = moved.unrounded[:4] * d / found.unrounded[:4]
    np.testing.assert_allclose(ratio / ratio[0], 1.0, rtol=1e-6)


def test_a_true_zero_of_rounding_stays_one() -> None:
    """Of a cascade in like units an entry 1e-17 on the way back steers nothing."""
    A = np.array([[-1.0, 1e-17], [1.0, -2.0]])
    assert np.array_equal(balance(A).states, balance(np.tril(A)).states)
