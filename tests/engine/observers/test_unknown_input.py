"""Unknown-input observers: they exist exactly where Chen and Patton's conditions say, and nothing of d reaches the error."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from observer_lab.engine import EngineError, Plant, PoleError, ShapeError, unknown_input_observer
from observer_lab.engine.observers import decoupling
from observer_lab.engine.systems import discretise
from observer_lab.plants.platform.model import deck

BOOK = Plant([[-1, 1, 0], [-1, 0, 0], [0, -1, -1]], [[-1], [0], [0]], [[1, 0, 0], [0, 0, 1]])
BOOK_E = np.array([[-1.0], [0.0], [0.0]])


def random_plant(seed, n, p, q, dt=0.0):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) * (0.4 if dt else 1.0)
    return Plant(A, rng.standard_normal((n, 2)), rng.standard_normal((p, n)), dt=dt), rng.standard_normal((n, q))


def rosenbrock_rank(plant, E, s):
    pencil = np.block([[s * np.eye(plant.n) - plant.A, -E], [plant.C, np.zeros((plant.p, E.shape[1]))]])
    values = np.linalg.svd(pencil, compute_uv=False)
    return int(np.count_nonzero(values > 1e-8 * values[0]))


def test_the_example_of_the_book():
    """Chen and Patton (1999), chapter 3: H = diag(1 0; 0 0; 0 0), T = diag(0, 1, 1), every pole free."""
    known = decoupling(BOOK, BOOK_E)
    assert known.exists and (known.rank_CE, known.rank_E) == (1, 1) and len(known.zeros) == 0
    assert np.allclose(known.H, [[1, 0], [0, 0], [0, 0]], atol=1e-14)
    assert np.allclose(known.T, np.diag([0, 1, 1]), atol=1e-14)
    assert np.allclose(known.A1, [[0, 0, 0], [-1, 0, 0], [0, -1, -1]], atol=1e-14)
    built = unknown_input_observer(BOOK, BOOK_E, [-2, -5, -10])
    assert np.allclose(built.poles, [-10, -5, -2], atol=1e-9)
    assert max(built.residuals(BOOK, BOOK_E)) < 1e-14


@settings(max_examples=60, derandomize=True)
@given(seed=st.integers(0, 10_000), n=st.integers(3, 7), q=st.integers(1, 2), sampled=st.booleans())
def test_the_conditions_of_the_observer_hold_to_rounding(seed, n, q, sampled):
    """T + HC = I, TE = 0 and TA = FT + KC, which are not the formulas it is built by."""
    plant, E = random_plant(seed, n, q + 1, q, 0.1 if sampled else 0.0)
    known = decoupling(plant, E)
    assert known.rank_CE == known.rank_E == q  # random matrices of these shapes never lose rank
    assume(known.exists)
    free = n - len(known.zeros)
    poles = np.linspace(0.1, 0.6, free) if sampled else -np.arange(1.0, free + 1)
    built = unknown_input_observer(plant, E, poles)
    assert max(built.residuals(plant, E)) <= 1e-9
    wanted = np.sort_complex(np.array([*poles, *known.zeros], dtype=complex))
    assert np.allclose(np.poly(built.poles), np.poly(wanted), rtol=1e-6, atol=1e-6)


@settings(max_examples=30, derandomize=True)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 6))
def test_zeros_are_where_the_pencil_loses_rank(seed, n):
    """Square plants have n − 1 invariant zeros; Rosenbrock's pencil [sI − A, −E; C, 0] drops rank there and nowhere near."""
    plant, E = random_plant(seed, n, 1, 1)
    known = decoupling(plant, E)
    assert len(known.zeros) == n - 1
    for zero in known.zeros:
        assert rosenbrock_rank(plant, E, zero) == n
        assert rosenbrock_rank(plant, E, zero + 0.3 + 0.2j) == n + 1
    assert known.exists == bool(np.all(known.zeros.real < 0))


@pytest.mark.parametrize("zero, exists", [(-2.0, True), (0.0, False), (2.0, False)])
def test_a_zero_that_is_not_stable_forbids_the_observer(zero, exists):
    """(s − zero)/(s² + 3 s + 2), observed through its output alone, in controller form."""
    plant = Plant([[0, 1], [-2, -3]], [[0], [1]], [[-zero, 1]])
    known = decoupling(plant, plant.B)
    assert np.allclose(known.zeros, [zero], atol=1e-12)
    assert known.exists is exists
    if exists:
        built = unknown_input_observer(plant, plant.B, [-4])
        assert np.allclose(built.fixed, [zero]) and np.allclose(built.poles, [-4, -2])
        return
    assert "invariant zero" in known.reason and "add a sensor" in known.reason
    with pytest.raises(EngineError, match="invariant zero"):
        unknown_input_observer(plant, plant.B, [-4])


def test_a_position_says_nothing_at_once_about_a_force():
    cart = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    known = decoupling(cart, cart.B)
    assert (known.rank_CE, known.rank_E) == (0, 1) and known.zeros is None
    with pytest.raises(EngineError, match=r"rank\(CE\) = 0 is less than rank\(E\) = 1"):
        unknown_input_observer(cart, cart.B, [-1, -2])


def test_the_error_obeys_its_own_equation_whatever_the_unknown_input_does():
    """An oracle that knows nothing of observers' formulas: the differential equations, integrated with a wild d."""
    built = unknown_input_observer(BOOK, BOOK_E, [-2, -3, -4])

    def slope(t, joint):
        x, z = joint[:3], joint[3:]
        u, d = np.array([np.sin(t)]), np.array([40 * np.sign(np.sin(5 * t)) + 9 * t])
        y = BOOK.C @ x
        return np.concatenate([BOOK.A @ x + BOOK.B @ u + BOOK_E @ d,
                               built.F @ z + built.T @ BOOK.B @ u + built.K @ y])

    x0 = np.array([1.0, -2.0, 0.5])
    run = solve_ivp(slope, (0, 2), np.concatenate([x0, np.zeros(3)]), rtol=1e-10, atol=1e-11, max_step=0.01)
    x, z = run.y[:3, -1], run.y[3:, -1]
    e0 = x0 - built.H @ BOOK.C @ x0
    assert np.linalg.norm(x) > 10  # the state was thrown about
    assert np.allclose(x - z - built.H @ BOOK.C @ x, expm(2 * built.F) @ e0, atol=1e-7)


def test_its_plant_gives_the_estimate_also_with_a_direct_term():
    rng = np.random.default_rng(3)
    base, E = random_plant(5, 4, 3, 1, dt=0.1)
    plant = Plant(base.A, base.B, base.C, rng.standard_normal((3, 2)), 0.1)
    built = unknown_input_observer(plant, E, [0.1, 0.2, 0.3, 0.4][:4 - len(decoupling(plant, E).zeros)])
    x, z = rng.standard_normal(4), np.zeros(4)
    errors = []
    for _ in range(60):
        u, d = rng.standard_normal(2), 10 * rng.standard_normal(1)
        known = np.concatenate([u, plant.C @ x + plant.D @ u])
        errors.append(np.linalg.norm(x - built.plant.C @ z - built.plant.D @ known) / max(np.linalg.norm(x), 1))
        x, z = plant.A @ x + plant.B @ u + E @ d, built.plant.A @ z + built.plant.B @ known
    assert errors[0] > 0.1 and errors[-1] < 1e-9


@pytest.mark.parametrize("coil", range(3))
def test_no_observer_of_the_whole_deck_ignores_a_coil(coil):
    """A constant force moves the deck and leaves every velocity at zero: the zero at s = 0, z = 1 when sampled."""
    plant = deck()
    known = decoupling(plant, plant.B[:, [coil]])
    assert known.rank_CE == known.rank_E == 1 and not known.exists
    assert np.allclose(known.zeros, [0], atol=1e-9)
    sampled = discretise(plant, 0.02)
    assert np.allclose(decoupling(sampled, sampled.B[:, [coil]]).unstable, [1], atol=1e-9)


def test_a_weight_makes_what_is_left_uncorrelated():
    plant, E = random_plant(8, 4, 3, 1)
    R = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])
    H = decoupling(plant, E, weight=R).H
    left = np.linalg.svd(plant.C @ E)[0][:, 1:]
    assert np.abs(H @ R @ left).max() < 1e-12
    assert np.allclose((np.eye(4) - H @ plant.C) @ E, 0, atol=1e-12)


def test_wrong_shapes_and_counts_are_named():
    with pytest.raises(ShapeError, match="E must have 3 rows"):
        decoupling(BOOK, [[1.0], [0.0]])
    with pytest.raises(EngineError, match="E is zero"):
        decoupling(BOOK, np.zeros((3, 1)))
    with pytest.raises(ShapeError, match="weight must be 2×2"):
        decoupling(BOOK, BOOK_E, weight=np.eye(3))
    with pytest.raises(PoleError, match="Give 3 poles"):
        unknown_input_observer(BOOK, BOOK_E, [-1, -2])
    assert decoupling(BOOK, np.hstack([BOOK_E, 2 * BOOK_E])).rank_E == 1  # the same direction twice


def test_a_weight_that_is_no_covariance_is_refused():
    for weight in (np.zeros((2, 2)), np.diag([1.0, -1.0]), np.array([[1.0, 0.5], [0.0, 1.0]])):
        with pytest.raises(EngineError, match="symmetric and positive definite"):
            decoupling(BOOK, BOOK_E, weight=weight)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_existence_does_not_depend_on_the_unit_of_time(unit):
    """Zeros of a plant whose time runs in nanoseconds, or in decades, were held against an absolute tolerance."""
    A, E, C = np.array([[0, 1, 0], [0, 0, 1], [-1, -2, -3.0]]), np.array([[0.0], [0.0], [1.0]]), np.array([[2.0, 3.0, 1.0]])
    plain, scaled = decoupling(Plant(A, np.eye(3), C), E), decoupling(Plant(unit * A, unit * np.eye(3), C), unit * E)
    assert plain.exists and scaled.exists, scaled.reason
    assert np.allclose(plain.zeros, [-2, -1]) and np.allclose(scaled.zeros, unit * plain.zeros, rtol=1e-9, atol=0)
