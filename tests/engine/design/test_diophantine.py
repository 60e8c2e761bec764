"""A E + B F = Φ: the identity holds, and its controller is the estimate feedback with the same poles."""

from __future__ import annotations

from fractions import Fraction

import control
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from observer_lab.engine import EngineError, Plant, PoleError, compensator, frequency_response, observer_gain, place, sensitivity
from observer_lab.engine.design import diophantine, rational, sylvester
from observer_lab.engine.feedback import to_tf
from observer_lab.engine.systems import match_poles


def test_a_double_integrator_by_hand() -> None:
    """A = s², B = 1, Φ = (s + 1)³: E = s + 3, F = 3 s + 1."""
    found = diophantine([1, 0, 0], [1], [1, 3, 3, 1])
    assert np.allclose(found.E, [1, 3]) and np.allclose(found.F, [3, 1])
    assert not found.strictly_proper and found.residual < 1e-15


def exactly(A: list[int], B: list[int], phi: list[int]) -> list[Fraction]:
    """Gauss elimination in fractions on the Sylvester matrix: the coefficients of E and F without rounding."""
    M = [[Fraction(int(v)) for v in row] + [Fraction(int(r))] for row, r in zip(sylvester(A, B, len(phi) - 1), phi, strict=True)]
    size = len(M)
    for k in range(size):
        pivot = next(r for r in range(k, size) if M[r][k] != 0)
        M[k], M[pivot] = M[pivot], M[k]
        M[k] = [v / M[k][k] for v in M[k]]
        for r in range(size):
            if r != k:
                M[r] = [x - M[r][k] * y for x, y in zip(M[r], M[k], strict=True)]
    return [row[-1] for row in M]


def test_the_solution_in_fractions() -> None:
    A, B, phi = [1, 2, 5, 7], [3, -4, 11], [1, 12, 60, 170, 300, 290, 120]
    found, right = diophantine(A, B, phi), exactly(A, B, phi)
    assert [*found.E, *found.F] == pytest.approx([float(v) for v in right], rel=1e-11)
    assert found.strictly_proper


coefficients = st.lists(st.floats(-3, 3), min_size=1, max_size=3)


@pytest.mark.slow
@settings(max_examples=80, derandomize=True, database=None)
@given(order=st.integers(1, 4), data=st.data(), size=st.floats(1e-2, 1e3))
def test_the_identity_holds_for_any_plant(order: int, data: st.DataObject, size: float) -> None:
    """Whatever the unit of time: s is scaled by `size`."""
    grow = size ** np.arange(order + 1)
    A = np.array([1.0, *data.draw(st.lists(st.floats(-3, 3), min_size=order, max_size=order))]) * grow
    B = np.array(data.draw(st.lists(st.floats(-3, 3), min_size=order, max_size=order))) * grow[:order]
    assume(np.abs(B[0]) > 0.1)
    phi = np.poly(-size * np.linspace(0.5, 3.0, 2 * order))
    try:
        found = diophantine(A, B, phi)
    except EngineError as problem:
        assert "share" in str(problem)
        return
    assert found.residual < 1e-9
    whole = np.polyadd(np.polymul(A, found.E), np.polymul(B, found.F))
    if found.condition < 1e6:
        assert np.abs(whole / phi - 1).max() < 1e-6


def test_the_polynomial_way_is_estimate_feedback() -> None:
    """Φ = Φ_c Φ_o and deg Φ = 2n: F/E is K(sI − A + BK + LC)⁻¹L with eig(A − BK), eig(A − LC) at the two sets."""
    plant = Plant([[0, 1, 0, 0], [-4, -0.2, 1, 0], [0, 0, 0, 1], [0.5, 0, -9, -0.1]], [[0], [1], [0], [0.3]], [[0, 1, 0, 0.2]])
    Kp, Lp = [-2 + 3j, -2 - 3j, -3 + 1j, -3 - 1j], [-5 + 4j, -5 - 4j, -6 + 2j, -6 - 2j]
    tf = to_tf(plant)
    found = diophantine(tf.den, tf.num[0, 0], np.real(np.poly([*Kp, *Lp])))
    state = compensator(plant, place(plant.A, plant.B, Kp).gain, observer_gain(plant.A, plant.C, Lp).gain)
    w = np.geomspace(0.01, 100, 30)
    ours = found.controller()
    a = frequency_response(ours.A, ours.B, ours.C, ours.D, w)
    b = frequency_response(state.A, state.B, state.C, state.D, w)
    assert np.abs(a / b - 1).max() < 1e-6
    loop = sensitivity(plant, ours)
    assert match_poles(np.array([*Kp, *Lp]), loop.poles)[1] < 1e-4
    peer = control.feedback(control.ss(plant.A, plant.B, plant.C, plant.D), control.tf(found.F, found.E))
    assert match_poles(np.array([*Kp, *Lp]), np.asarray(peer.poles()))[1] < 1e-4


def test_errors_name_what_is_wrong() -> None:
    with pytest.raises(EngineError, match=r"share the factor at s = -2"):
        diophantine(np.poly([-2, -3]), [1, 2], np.poly([-4, -5, -6, -7]))
    with pytest.raises(EngineError, match=r"share the factor at s = 0"):
        diophantine([1, 1, 0], [1, 0], np.poly([-4, -5, -6, -7]))
    with pytest.raises(PoleError, match="at least 3 poles"):
        diophantine([1, 0, 1], [1], [1, 2, 1])
    with pytest.raises(EngineError, match="strictly proper"):
        diophantine([1, 2], [1, 1], [1, 2])
    with pytest.raises(EngineError, match="finite"):
        diophantine([1, np.nan], [1], [1, 2])


def test_the_controller_carries_the_sign_of_the_feedback() -> None:
    found = diophantine([1, -1], [2], np.poly([-3, -4]))
    assert sensitivity(rational([2], [1, -1]), found.controller()).poles == pytest.approx([-4, -3])
