"""The bilinear functional observer on any plant: the three cases, units, several inputs, noise, requests that make no sense."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from observer_lab.engine import BilinearPlant, EngineError, PoleError, ShapeError, bilinear_functional_observer, simulate_bilinear
from observer_lab.plants import bilinear as example

P = example.BILINEAR_PLANT


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


@settings(max_examples=40)
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


@settings(max_examples=20)
@given(st.integers(0, 10**6))
def test_case_2_as_many_conditions_as_outputs_leave_one_gain(seed):
    plant = plant_of(seed, 5, 3)  # Q is 3×3
    K = np.random.default_rng(seed + 1).standard_normal((1, 5))
    o = bilinear_functional_observer(plant.A, plant.B, plant.F, plant.C, K, -4)
    assert o.case == 2 and o.pi is None and o.controllable is None
    assert o.solved == bool(o.A_L.item() < 0)
    assert law_residual(plant, o.without_derivative, K, o.A_L, o.readout, seed) < 1e-7


@settings(max_examples=20)
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
    o = bilinear_functional_observer(P.A, P.B, P.F, P.C, example.WANTED_ROW, 2.0)
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
    request = {"A": P.A, "B": P.B, "F": P.F, "C": P.C, "K": example.WANTED_ROW, "pole": -30.0} | change
    with pytest.raises(error, match=word):
        bilinear_functional_observer(**request)


@settings(max_examples=25, derandomize=True, database=None)
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


@settings(max_examples=6, derandomize=True, database=None)
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


def test_a_run_is_refused_where_its_parts_do_not_fit():
    observer = bilinear_functional_observer(*(getattr(example.BILINEAR_PLANT, k) for k in "ABFC"), example.WANTED_ROW, example.POLE)
    form, x0, z0 = observer.without_derivative, np.ones(observer.plant.n), np.zeros(observer.order)
    with pytest.raises(EngineError, match="x0 holds NaN"):
        simulate_bilinear(observer.plant, form, observer.K, np.sin, np.nan * x0, z0)
    with pytest.raises(ShapeError, match="K must have"):
        simulate_bilinear(observer.plant, form, np.ones((1, 2)), np.sin, x0, z0)
    with pytest.raises(ShapeError, match="as many numbers"):
        simulate_bilinear(observer.plant, form, observer.K, lambda t: np.ones(7), x0, z0)
