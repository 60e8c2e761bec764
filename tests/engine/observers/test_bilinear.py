"""The bilinear functional observer: the worked example in fractions, its slips, the three cases, every input."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from app.engine import (
    BilinearPlant,
    EngineError,
    PoleError,
    ShapeError,
    bilinear_functional_observer,
    simulate_bilinear,
)
from app.engine.observers import BilinearForm
from app.engine.structure import canonise, canonise_right
from app.plants import bilinear as example

P = example.PLANT
OBSERVER = bilinear_functional_observer(P.A, P.B, P.F, P.C, example.K, example.POLE)
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


def plant_of(seed, n, m, inputs=1):
    rng = np.random.default_rng(seed)
    return BilinearPlant(rng.standard_normal((n, n)), rng.standard_normal((n, inputs)), rng.standard_normal((n, inputs * n)),
                         rng.standard_normal((m, n)))


def law_residual(plant, form, K, A_w, readout, seed):
    """‖d/dt(ĝ − g) − readout A_w w‖ relative, from the definition of plant and observer at a random (x, z, u)."""
    rng = np.random.default_rng(seed)
    x, z, u = rng.standard_normal(plant.n), rng.standard_normal(len(form.A)), rng.uniform(-3, 3, plant.B.shape[1])
    dx = plant.A @ x + plant.B @ u + plant.F @ np.kron(u, x)
    y, dy = plant.C @ x, plant.C @ dx
    dz = form.A @ z + form.Y @ y + form.B @ u + form.U @ np.kron(u, y) + form.R @ dy
    error = form.G_y @ y + form.G_z @ z - K @ x
    rate = form.G_y @ dy + form.G_z @ dz - K @ dx
    w = np.linalg.lstsq(readout, error, rcond=None)[0]
    size = np.linalg.norm(form.G_y @ dy) + np.linalg.norm(form.G_z @ dz) + np.linalg.norm(K @ dx)
    return np.linalg.norm(rate - readout @ A_w @ w) / size


# --- the worked example --------------------------------------------------------------------------------------------


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
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.K, u, example.X0, [0.0])
    assert run.g[0, 0] == pytest.approx(21, abs=1e-12)
    law = -1318 / 85 * np.exp(-30 * run.t)
    np.testing.assert_allclose(run.error[:, 0], law, rtol=0, atol=2e-11)


@pytest.mark.parametrize("u", INPUTS.values(), ids=INPUTS.keys())
def test_both_forms_are_one_observer(u):
    """μ̂ = χ + L y: started alike, the form with ẏ and the one without give the same estimate."""
    y0 = P.C @ np.ones(6)
    plain = simulate_bilinear(P, OBSERVER.without_derivative, example.K, u, example.X0, [0.0])
    fed = simulate_bilinear(P, OBSERVER.with_derivative, example.K, u, example.X0, OBSERVER.L @ y0)
    np.testing.assert_allclose(fed.estimate, plain.estimate, atol=1e-10)


def test_the_plant_moves_as_an_adaptive_solver_says():
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.K, INPUTS["sine"], example.X0, [0.0])

    def rate(t, x):
        u = np.sin(2 * t)
        return P.A @ x + P.B[:, 0] * u + u * P.F @ x

    peer = solve_ivp(rate, (0, 1), example.X0, "DOP853", [0.25, 0.5, 1.0], rtol=1e-11, atol=1e-13).y.T
    np.testing.assert_allclose(run.x[[125, 250, 500]], peer, atol=1e-8)


def test_several_inputs_move_plant_and_observer_as_an_adaptive_solver_says():
    """Two inputs, the second one also multiplied: the plant and (18) from their matrices, and an error that hears neither."""
    plant, K = plant_of(5, 5, 4, 2), np.ones((1, 5))
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, -3)
    form = o.without_derivative
    run = simulate_bilinear(plant, form, K, lambda t: np.stack([np.sin(3 * t), 0.5 * np.cos(t)], axis=-1), np.ones(5), [0.0])

    def rate(t, s):
        x, z, u = s[:5], s[5:], np.array([np.sin(3 * t), 0.5 * np.cos(t)])
        y = plant.C @ x
        return np.append(plant.A @ x + plant.B @ u + plant.F @ np.kron(u, x), form.A @ z + form.Y @ y + form.B @ u + form.U @ np.kron(u, y))
    peer = solve_ivp(rate, (0, 1), [1, 1, 1, 1, 1, 0], "DOP853", [0.5, 1.0], rtol=1e-11, atol=1e-13).y.T
    np.testing.assert_allclose(np.hstack([run.x, run.z])[[250, 500]], peer, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(run.error[:, 0], run.error[0, 0] * np.exp(-3 * run.t), atol=1e-9 * np.abs(run.g).max())
    assert o.case == 3 and o.advised and run.u.shape == (501, 2)


def test_printed_coefficients_leave_a_floor():
    """Two decimals break the structural zeros: the error stops falling near 5.2e-3 instead of at rounding."""
    form = BilinearForm(*(np.array(m) for m in (
        [[-30.0]], [[-273.64, -213.93, 408.38, -198.94]], [[8.85]], [[-44.26, 27.98, -81.33, 36.08]],
        np.zeros((1, 4)), [[-11.49, 19.68, -15.99, 13.29]], [[1.0]])))
    run = simulate_bilinear(P, form, example.K, INPUTS["sine"], example.X0, [0.0], horizon=6.0)
    late = np.abs(run.error[run.t > 2, 0]).max()
    assert 1e-3 < late < 2e-2
    ours = simulate_bilinear(P, OBSERVER.without_derivative, example.K, INPUTS["sine"], example.X0, [0.0], horizon=6.0)
    assert np.abs(ours.error[ours.t > 2, 0]).max() < 1e-11


def test_a_plant_that_runs_away_is_cut_off():
    run = simulate_bilinear(P, OBSERVER.without_derivative, example.K, lambda t: -40.0, example.X0, [0.0],
                            horizon=20.0, dt=0.01)
    assert run.diverged_at is not None and np.isfinite(run.x).all() and len(run.t) == len(run.x) < 2001


# --- any plant: the three cases ------------------------------------------------------------------------------------


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([
    (4, 3, 1, 1), (5, 4, 1, 1), (6, 4, 1, 1), (7, 5, 2, 1), (8, 6, 2, 1), (5, 4, 1, 2), (8, 6, 2, 2), (5, 4, 1, 3), (9, 7, 2, 3)]))
def test_case_3_on_random_plants_the_law_holds_at_every_point(seed, shape):
    n, m, r, inputs = shape
    plant = plant_of(seed, n, m, inputs)
    K = np.random.default_rng(seed + 1).standard_normal((r, n))
    poles = [-2.0, -3.5][:r]
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, poles)
    assert o.case == 3 and o.solved
    np.testing.assert_allclose(np.sort(o.reached.real), np.sort(poles), rtol=1e-6)
    for form in (o.without_derivative, o.with_derivative):
        assert law_residual(plant, form, K, o.A_L, o.readout, seed) < 1e-8


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_case_2_as_many_conditions_as_outputs_leave_one_gain(seed):
    plant = plant_of(seed, 5, 3)  # Q is 3×3
    K = np.random.default_rng(seed + 1).standard_normal((1, 5))
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, -4)
    assert o.case == 2 and o.pi is None and o.controllable is None
    assert o.solved == bool(o.A_L.item() < 0)
    assert law_residual(plant, o.without_derivative, K, o.A_L, o.readout, seed) < 1e-7


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_case_1_more_conditions_than_outputs(seed):
    plant = plant_of(seed, 6, 2)  # Q is 2×7
    K = np.random.default_rng(seed + 1).standard_normal((1, 6))
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, -4)
    block = np.hstack([plant.F @ o.T[1], plant.A @ o.T[2], plant.F @ o.T[2]])
    wanted, have = o.V[1] @ block, o.V[0] @ block
    gap = wanted - np.linalg.lstsq(have.T, wanted.T, rcond=None)[0].T @ have
    assert np.linalg.norm(gap) > 1e-6  # no L by least squares either
    assert o.case == 1 and not o.solved and not o.advised and o.L is None and o.without_derivative is None
    assert "(21)" in o.reason


def test_a_family_whose_pole_stays_put_says_so():
    """Q̄ᴸ V₁ A T₂ = 0: L is free but μ leaves no trace in what is left of ẏ."""
    A = np.array([[0.0, 0, 0], [0, 0, 0], [0, 0, -1]])
    o = bilinear_functional_observer(A, np.ones((3, 1)), np.zeros((3, 3)), np.eye(3)[:2], [[0, 0, 1]], -5)
    assert o.case == 3 and o.controllable is False and not o.solved and "poles" in o.reason


def test_an_unstable_pole_is_no_observer():
    o = bilinear_functional_observer(P.A, P.B, P.F, P.C, example.K, 2.0)
    assert o.case == 3 and not o.solved and "decay" in o.reason


@pytest.mark.parametrize(("change", "error", "word"), [
    ({"C": np.eye(6)}, EngineError, "6 states"),
    ({"C": np.ones((2, 6))}, EngineError, "depend"),
    ({"K": np.eye(6)[:1]}, EngineError, "directly"),
    ({"K": np.zeros((1, 6))}, EngineError, "zero"),
    ({"K": np.ones((1, 5))}, ShapeError, "6 columns"),
    ({"F": np.eye(5)}, ShapeError, "6×6"),
    ({"B": np.eye(6)}, ShapeError, "6×36"), ({"B": np.ones((5, 1))}, ShapeError, "6×1"),
    ({"pole": -3 + 1j}, PoleError, "conjugate"),
    ({"pole": float("nan")}, PoleError, "NaN"),
])
def test_requests_that_make_no_sense_get_one_sentence(change, error, word):
    request = {"A": P.A, "B": P.B, "F": P.F, "C": P.C, "K": example.K, "pole": -30.0} | change
    with pytest.raises(error, match=word):
        bilinear_functional_observer(**request)


@settings(max_examples=25, deadline=None, derandomize=True, database=None)
@given(st.integers(0, 10**6), st.sampled_from([
    (4, 3, 1, 1), (5, 3, 1, 1), (6, 2, 1, 1), (7, 5, 1, 1), (8, 5, 2, 1), 
    (8, 6, 2, 1), (10, 8, 2, 1), (5, 4, 1, 2), (6, 4, 1, 2), (9, 7, 2, 3)]))
def test_units_decide_nothing(seed, shape):
    """x = X x′, u = U u′, y = Y y′, g = S g′, t = τ t′: the case, its poles and the law of the error are the same, whatever the units."""
    n, m, r, inputs = shape
    plant, rng = plant_of(seed, n, m, inputs), np.random.default_rng(seed + 1)
    K = rng.standard_normal((r, n))
    X, Y, S = (10 ** rng.uniform(-6, 6, k) for k in (n, m, r))
    U, tau = 10 ** rng.uniform(-6, 6, inputs), 10 ** rng.uniform(-3, 3)
    poles = np.array([-2.0, -3.5][:r])
    own = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, poles)
    other = bilinear_functional_observer(tau * plant.A * X / X[:, None], tau * plant.B * U / X[:, None],
                                         tau * plant.F * np.kron(U, X) / X[:, None],
                                         plant.C * X / Y[:, None], K * X / S[:, None], tau * poles)
    assert (other.case, other.order, other.solved, other.controllable, other.advised) == (
        own.case, own.order, own.solved, own.controllable, own.advised)
    if own.case == 1:
        return
    np.testing.assert_allclose(np.poly(other.reached / tau), np.poly(own.reached), rtol=1e-6, atol=1e-6)
    if own.case == 2:  # one observer: its answers to y are one map
        told = other.without_derivative.G_y * S[:, None] / Y
        np.testing.assert_allclose(told, own.without_derivative.G_y, rtol=1e-5, atol=1e-6 * np.abs(own.without_derivative.G_y).max())
    T, V = np.hstack(other.T) / X[:, None], np.vstack(other.V) * X
    np.testing.assert_allclose(V @ T, np.eye(n), atol=1e-6 * max(np.abs(np.abs(V) @ np.abs(T)).max(), 1))
    c = other.canonical_Q
    shape = np.zeros(other.Q.shape)
    shape[:c.rank, :c.rank] = np.eye(c.rank)
    np.testing.assert_allclose(c.left @ other.Q @ c.right, shape, atol=1e-7 * (np.abs(c.left) @ np.abs(other.Q) @ np.abs(c.right)).max())


def test_one_pole_serves_every_state_and_the_pair_says_what_it_could_do():
    plant = plant_of(3, 8, 6)
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, np.random.default_rng(4).standard_normal((2, 8)), -4.0)
    assert o.order == 2 and o.asked.tolist() == [-4, -4] and o.observable
    np.testing.assert_allclose(np.poly(o.reached), [1, 8, 16], rtol=1e-6)
    blind = bilinear_functional_observer(np.diag([0.0, 0, -1]), np.ones((3, 1)), np.zeros((3, 3)), np.eye(3)[:2], [[0, 0, 1]], -5)
    assert not blind.observable


@settings(max_examples=6, deadline=None, derandomize=True, database=None)
@given(st.integers(0, 10**6))
def test_noise_is_heard_as_the_exact_response_to_held_values_says(seed):
    """At u = 0 what noise adds to ĝ is G_y v + G_z z with ż = A z + Y v, v held: by matrix exponentials."""
    plant, rng = plant_of(seed, 5, 4), np.random.default_rng(seed + 1)
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, rng.standard_normal((1, 5)), -4.0)
    form, h, count = o.without_derivative, 0.01, 60
    v = rng.standard_normal((count + 1, 4))
    x0 = rng.standard_normal(5)

    def run(noise):
        return simulate_bilinear(o.plant, form, o.K, lambda t: 0.0 * t, x0, [0.3], horizon=count * h, dt=h, noise=noise)
    still, noisy = run(None), run(v)
    np.testing.assert_allclose(noisy.x, still.x, rtol=1e-9, atol=1e-12 * np.abs(still.x).max())
    np.testing.assert_allclose(noisy.y - still.y, v, atol=1e-12 * np.abs(still.y).max() + 1e-12)
    a, z, added = form.A.item(), 0.0, []
    for heard in v:
        added.append((form.G_y @ heard + form.G_z[:, 0] * z).item())
        z = np.exp(a * h) * z + (np.exp(a * h) - 1) / a * (form.Y @ heard).item()
    np.testing.assert_allclose((noisy.estimate - still.estimate)[:, 0], added, atol=1e-9 * np.abs(added).max())
    with pytest.raises(ShapeError, match="a row for each time"):
        run(v[:-1])


# --- canonisation --------------------------------------------------------------------------------------------------


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 6), st.integers(0, 6))
def test_divisors_of_zero_and_of_one(seed, p, q, rank):
    rng = np.random.default_rng(seed)
    rank = min(rank, p, q)
    M = rng.standard_normal((p, rank)) @ rng.standard_normal((rank, q)) * 10.0 ** rng.integers(-6, 6)
    for c in (canonise(M), canonise_right(M)):
        assert c.rank == rank == np.linalg.matrix_rank(M)
        left, right = np.vstack([c.unit_left, c.zero_left]), np.hstack([c.unit_right, c.zero_right])
        shape = np.zeros((p, q))
        shape[:rank, :rank] = np.eye(rank)
        np.testing.assert_allclose(left @ M @ right, shape, atol=1e-7)
        assert np.linalg.matrix_rank(left) == p and np.linalg.matrix_rank(right) == q
        np.testing.assert_allclose(M @ c.summary @ M, M, atol=1e-7 * np.abs(M).max(initial=1e-300))


def test_a_run_is_refused_where_its_parts_do_not_fit():
    observer = bilinear_functional_observer(*(getattr(example.PLANT, k) for k in "ABFC"), example.K, example.POLE)
    form, x0, z0 = observer.without_derivative, np.ones(observer.plant.n), np.zeros(observer.order)
    with pytest.raises(EngineError, match="x0 holds NaN"):
        simulate_bilinear(observer.plant, form, observer.K, np.sin, np.nan * x0, z0)
    with pytest.raises(ShapeError, match="K must have"):
        simulate_bilinear(observer.plant, form, np.ones((1, 2)), np.sin, x0, z0)
    with pytest.raises(ShapeError, match="as many numbers"):
        simulate_bilinear(observer.plant, form, observer.K, lambda t: np.ones(7), x0, z0)
