"""The worked example of the bilinear functional observer: in fractions, as printed and where it slips, and its run under every input."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from observer_lab.engine import bilinear_functional_observer, simulate_bilinear
from observer_lab.engine.observers import BilinearForm
from observer_lab.plants import bilinear as example

P = example.BILINEAR_PLANT
OBSERVER = bilinear_functional_observer(P.A, P.B, P.F, P.C, example.WANTED_ROW, example.POLE)
INPUTS = {
    "sine": lambda t: np.sin(2 * t),
    "rest": lambda t: 0.0,
    "step": lambda t: 1.5,
    "square": lambda t: np.sign(np.sin(23 * t)),
    "chirp": lambda t: 2 * np.cos(40 * t * t),
    "pushed": lambda t: np.exp(-t) * np.sin(9 * t) - 0.5,
}


def exactly(matrix, *fractions):
    np.testing.assert_allclose(np.ravel(matrix), [float(Fraction(f)) for f in fractions], rtol=1e-13, atol=1e-13)


def rounded(matrix, printed, digits=2):
    np.testing.assert_array_equal(np.round(np.ravel(matrix), digits) + 0.0, printed)


# --- the observer --------------------------------------------------------------------------------------------------
def test_step_1_the_coordinates():
    exactly(OBSERVER.T[1], 0, 0, 0, 0, "1/5", 0)
    exactly(OBSERVER.T[2], 0, 0, 0, 0, "-6/5", 1)
    exactly(OBSERVER.V[1], 0, 0, 0, 0, 5, 6)
    assert OBSERVER.canonical_K1.unit_left == 1 and OBSERVER.order == 1


def test_step_2_canonisation_of_Q():
    exactly(OBSERVER.Q, "-2/5", "27/5", "12/5", 0, 11, 1, "1/5", "-21/5", "4/5", 0, -19, 1)
    exactly(OBSERVER.canonical_Q.zero_left, "-30/47", "73/47", "-60/47", 1)
    rounded(OBSERVER.canonical_Q.zero_left, [-0.64, 1.55, -1.28, 1])
    rounded(OBSERVER.canonical_Q.unit_left, [-2.5, 0, 0, 0, 0, 0.09, 0, 0, 0.23, 0.06, 0.47, 0])
    rounded(OBSERVER.canonical_Q.unit_right, [1, 13.5, 4.77, 0, 1, -0.09, 0, 0, 1])
    rounded(OBSERVER.canonical_Q.summary, [-1.38, 1.53, 2.23, 0, -0.02, 0.09, -0.04, 0, 0.23, 0.06, 0.47, 0])


def test_steps_3_to_6():
    assert OBSERVER.canonical_Q.zero_right.shape[1] == 0 and OBSERVER.defect_size == 0
    assert OBSERVER.case == 3 and OBSERVER.controllable and OBSERVER.advised and OBSERVER.solved
    exactly(OBSERVER.A_star, "-304/47")
    exactly(OBSERVER.B_star, "119/47")
    exactly(OBSERVER.pi, "158/17")
    rounded(OBSERVER.pi, [9.29])


def test_step_7_the_gain_and_its_slip():
    exactly(OBSERVER.L, "-1062/85", "1503/85", "-1614/85", "158/17")
    rounded(OBSERVER.L, [-12.49, 17.68, -18.99, 9.29])  # printed: 2.29
    slip = OBSERVER.L.copy()
    slip[0, 3] = 2.29
    pole = ((OBSERVER.V[1] - slip @ OBSERVER.V[0]) @ P.A @ OBSERVER.T[1]).item()
    assert round(pole, 2) == 5.02  # with the printed digit the observer runs away


def test_step_8_the_form_without_derivative():
    form = OBSERVER.without_derivative
    exactly(form.A, -30)
    np.testing.assert_allclose(form.Y[0], [-273.6471, -213.9294, 408.3765, -198.9412], atol=5e-5)
    rounded(form.Y[0, 1:], [-213.93, 408.38, -198.94])
    assert round(form.Y[0, 0], 2) == -273.65  # printed: −273.64
    exactly(form.B, "752/85")
    np.testing.assert_allclose(form.U[0], [-44.2588, 27.9765, -81.3294, 36.0824], atol=5e-5)
    rounded(form.U, [-44.26, 27.98, -81.33, 36.08])
    np.testing.assert_allclose(form.G_y[0], [-11.4941, 19.6824, -15.9882, 13.2941], atol=5e-5)
    rounded(form.G_y, [-11.49, 19.68, -15.99, 13.29])
    exactly(form.G_z, 1)
    assert not form.R.any()


def test_the_plant_is_stable_as_published():
    poles = np.sort_complex(np.linalg.eigvals(P.A))
    np.testing.assert_allclose(poles, [-18.8987 - 9.2476j, -18.8987 + 9.2476j, -4.9342 - 3.7176j, -4.9342 + 3.7176j,
                                       -2.6671 - 7.6014j, -2.6671 + 7.6014j], atol=6e-5)


# --- the run -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("u", INPUTS.values(), ids=INPUTS.keys())
def test_the_error_decays_with_the_pole_under_every_input(u):
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.WANTED_ROW, u, example.X0, [0.0])
    assert run.g[0, 0] == pytest.approx(21, abs=1e-12)
    law = -1318 / 85 * np.exp(-30 * run.t)
    np.testing.assert_allclose(run.error[:, 0], law, rtol=0, atol=2e-11)


@pytest.mark.parametrize("u", INPUTS.values(), ids=INPUTS.keys())
def test_both_forms_are_one_observer(u):
    """μ̂ = χ + L y: started alike, the form with ẏ and the one without give the same estimate."""
    y0 = P.C @ np.ones(6)
    plain = simulate_bilinear(P, OBSERVER.without_derivative, example.WANTED_ROW, u, example.X0, [0.0])
    fed = simulate_bilinear(P, OBSERVER.with_derivative, example.WANTED_ROW, u, example.X0, OBSERVER.L @ y0)
    np.testing.assert_allclose(fed.estimate, plain.estimate, atol=1e-10)


def test_the_plant_moves_as_an_adaptive_solver_says():
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.WANTED_ROW, INPUTS["sine"], example.X0, [0.0])

    def rate(t, x):
        u = np.sin(2 * t)
        return P.A @ x + P.B[:, 0] * u + u * P.F @ x

    peer = solve_ivp(rate, (0, 1), example.X0, "DOP853", [0.25, 0.5, 1.0], rtol=1e-11, atol=1e-13).y.T
    np.testing.assert_allclose(run.x[[125, 250, 500]], peer, atol=1e-8)


def test_printed_coefficients_leave_a_floor():
    """Two decimals break the structural zeros: the error stops falling near 5.2e-3 instead of at rounding."""
    form = BilinearForm(*(np.array(m) for m in (
        [[-30.0]], [[-273.64, -213.93, 408.38, -198.94]], [[8.85]], [[-44.26, 27.98, -81.33, 36.08]],
        np.zeros((1, 4)), [[-11.49, 19.68, -15.99, 13.29]], [[1.0]])))
    run = simulate_bilinear(P, form, example.WANTED_ROW, INPUTS["sine"], example.X0, [0.0], horizon=6.0)
    late = np.abs(run.error[run.t > 2, 0]).max()
    assert 1e-3 < late < 2e-2
    ours = simulate_bilinear(P, OBSERVER.without_derivative, example.WANTED_ROW, INPUTS["sine"], example.X0, [0.0], horizon=6.0)
    assert np.abs(ours.error[ours.t > 2, 0]).max() < 1e-11


def test_a_plant_that_runs_away_is_cut_off():
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.WANTED_ROW, lambda t: -40.0, example.X0, [0.0],
                            horizon=20.0, dt=0.01)
    assert run.diverged_at is not None and np.isfinite(run.x).all() and len(run.t) == len(run.x) < 2001
