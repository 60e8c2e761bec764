"""SISO controllers: the realisation keeps what the polynomials say, however badly they are scaled."""

from __future__ import annotations

import control
import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, ShapeError, frequency_response
from observer_lab.engine.design import LoopShape, diagonal_controller, loop_shaped, negated, polynomial_roots, rational, realise, series

OMEGA = np.geomspace(1e-3, 1e4, 60)


def response(plant: Plant, omega: np.ndarray = OMEGA) -> np.ndarray:
    """By solving at each frequency: residues would lose digits where poles nearly coincide."""
    D = np.asarray(plant.D)
    return np.array([(plant.C @ np.linalg.solve(1j * w * np.eye(plant.n) - plant.A, plant.B) + D)[0, 0] for w in omega])


def exact(numerator: list[str], denominator: list[str], omega: float) -> complex:
    """N(jω)/D(jω) from the printed decimals in 50 digits."""
    with mpmath.workdps(50):
        s = mpmath.mpc(0, omega)
        return complex(mpmath.polyval([mpmath.mpf(c) for c in numerator[::-1]], s, asc=True)
                       / mpmath.polyval([mpmath.mpf(c) for c in denominator[::-1]], s, asc=True))


def test_roots_of_a_graded_polynomial_are_those_of_fifty_digits() -> None:
    """The companion matrix of C_v alone would blur the pole at 8e-11 by rounding at 1e5."""
    printed = ["1", "1.366e5", "134.9", "-1.071e-8"]
    with mpmath.workdps(50):
        ascending = [mpmath.mpf(c) for c in printed[::-1]]
        right = sorted(float(mpmath.re(r)) for r in mpmath.polyroots(ascending, maxsteps=200, extraprec=200, asc=True))
    assert np.allclose(np.real(polynomial_roots([float(c) for c in printed])), right, rtol=1e-14, atol=0)


def test_a_polynomial_over_sixteen_decades_is_realised_to_rounding() -> None:
    num, den = ["-4.269e9", "-49.34", "-0.8706"], ["1", "1.366e5", "134.9", "-1.071e-8"]
    plant = rational([float(c) for c in num], [float(c) for c in den])
    omega = np.geomspace(1e-8, 1e8, 80)
    right = np.array([exact(num, den, float(w)) for w in omega])
    assert np.abs(response(plant, omega) / right - 1).max() < 1e-12


roots = st.lists(st.tuples(st.floats(-50, -0.01), st.floats(0.01, 100)), min_size=1, max_size=3)


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, database=None)
@given(pairs=roots, singles=st.lists(st.floats(-50, -0.01), max_size=3), zero=st.floats(-40, 40), gain=st.floats(-5, 5))
def test_any_set_of_roots_is_realised(pairs: list[tuple[float, float]], singles: list[float], zero: float, gain: float) -> None:
    poles = [complex(a, s * b) for a, b in pairs for s in (1, -1)] + [complex(a) for a in singles]
    plant = realise([zero], poles, gain)
    s = 1j * OMEGA
    right = gain * (s - zero) / np.prod([s - p for p in poles], axis=0)
    assert plant.n == len(poles)
    assert np.abs(response(plant) - right).max() <= 1e-8 * np.abs(right).max() + 1e-300


@pytest.mark.parametrize("poles", [[-2, -2, -2], [-3 + 4j, -3 - 4j, -3 + 4j, -3 - 4j], [-1, -1, -5], [0, 0]])
def test_repeated_poles_fall_back_to_sections(poles: list[complex]) -> None:
    zeros = [-7.0, 2.0][:len(poles)]
    s = 1j * OMEGA
    right = 3 * np.prod([s - z for z in zeros], axis=0) / np.prod([s - p for p in poles], axis=0)
    assert np.abs(response(realise(zeros, poles, 3.0)) / right - 1).max() < 1e-8


def test_a_loop_shape_is_its_formula() -> None:
    shape = LoopShape(-40.0, lag=(2.0, 0.1), lead=(20.0, 90.0), roll_off=300.0, order=2)
    s = 1j * OMEGA
    right = -40 * (s + 2) / (s + 0.1) * (s / 20 + 1) / (s / 90 + 1) / (s / 300 + 1)**2
    assert np.abs(response(loop_shaped(shape)) / right - 1).max() < 1e-10
    assert np.abs(response(loop_shaped(LoopShape(2.5))) - 2.5).max() == 0
    with pytest.raises(EngineError, match="positive"):
        loop_shaped(LoopShape(1.0, lead=(-3.0, 2.0)))
    with pytest.raises(EngineError, match="order"):
        loop_shaped(LoopShape(1.0, roll_off=2.0, order=9))


def test_series_is_the_product_of_python_control() -> None:
    rng = np.random.default_rng(3)
    one, two = (Plant(rng.normal(size=(3, 3)) - 4 * np.eye(3), rng.normal(size=(3, 2)), rng.normal(size=(2, 3)),
                      rng.normal(size=(2, 2))) for _ in range(2))
    whole = series(two, one)
    peer = control.ss(two.A, two.B, two.C, two.D) * control.ss(one.A, one.B, one.C, one.D)
    w = np.array([0.1, 1.0, 30.0])
    ours = frequency_response(whole.A, whole.B, whole.C, whole.D, w)
    assert np.allclose(ours, np.moveaxis(peer(1j * w), -1, 0), rtol=1e-9)
    with pytest.raises(ShapeError):
        series(loop_shaped(LoopShape(1.0)), one)


def test_a_diagonal_controller_is_the_product_of_its_parts() -> None:
    T_y, T_u = np.array([[0.5, 0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.0, 1.0]]), np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0]])
    first, third = loop_shaped(LoopShape(-3.0, roll_off=5.0)), negated(rational([1.0, 2.0], [1.0, 0.2, 9.0]))
    whole = diagonal_controller((first, None, third), T_y, T_u, name="two loops")
    H = frequency_response(whole.A, whole.B, whole.C, whole.D, OMEGA)
    middle = np.zeros((len(OMEGA), 3, 3), dtype=complex)
    middle[:, 0, 0], middle[:, 2, 2] = response(first), response(third)
    assert np.allclose(H, T_u @ middle @ T_y, rtol=1e-10)
    with pytest.raises(ShapeError, match="channels"):
        diagonal_controller((first,), T_y, T_u)


def test_what_is_not_a_controller_is_refused_in_a_sentence() -> None:
    with pytest.raises(EngineError, match="zeros"):
        realise([-1, -2], [-3], 1.0)
    with pytest.raises(EngineError, match="conjugate"):
        realise([], [-1 + 2j], 1.0)
    with pytest.raises(EngineError, match="denominator"):
        rational([1.0], [0.0])
    assert rational([0.0], [1.0, 2.0]).n == 0


def test_pairs_that_differ_in_rounding_are_still_pairs() -> None:
    """Sorting by real part tore apart pairs that stand above each other, their real parts a rounding apart."""
    rng = np.random.default_rng(0)
    poles = np.array([-1 + 1j, -1 + 2j, -1 + 3j])
    for _ in range(50):
        near = np.concatenate([poles, poles.conj()]) * (1 + 1e-15 * rng.standard_normal(6))
        assert np.allclose(response(realise([], near, 6.0)), 6 / np.polyval(np.poly(near), 1j * OMEGA), rtol=1e-9)


def test_coefficients_must_be_finite_real_numbers() -> None:
    for wrong in ([1.0, np.nan], "s + 1", np.array([1.0, 1j]), [[1.0, 3.0], [2.0, 4.0]]):
        with pytest.raises(EngineError, match="polynomial"):
            polynomial_roots(wrong)
        with pytest.raises(EngineError, match="numerator"):
            rational(wrong, [1.0, 2.0, 3.0])
    with pytest.raises(EngineError, match="1 to 6"):
        loop_shaped(LoopShape(1.0, roll_off=5.0, order=1.5))  # type: ignore[arg-type]
