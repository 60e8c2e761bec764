"""Optimal gains: closed forms, published numbers, Riccati residuals, independence of scale, honest refusals."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
import scipy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mpmath import mp
from scipy.linalg import solve_continuous_lyapunov

from observer_lab.engine import EngineError, Plant, RiccatiError, ShapeError, dlqe, dlqr, lqe, lqr
from observer_lab.engine.design import riccati
from observer_lab.engine.systems.noise import step_covariance
from observer_lab.engine.systems.sampling import discretise

ONES = np.ones((2, 2))
DOYLE_A, DOYLE_B, DOYLE_C = np.array([[1.0, 1.0], [0.0, 1.0]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]])


def pair(seed, n, m):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, n)), rng.standard_normal((n, m))


def weight(seed, n, floor):
    half = np.random.default_rng(seed).standard_normal((n, n))
    return half @ half.T + floor * np.eye(n)


# --- closed forms and published numbers ------------------------------------------------------------------------------


@pytest.mark.parametrize("q", [1.0, 60.0, 1000.0])
def test_doyle_1978_gains(q):
    f = 2 + np.sqrt(4 + q)
    np.testing.assert_allclose(lqr(DOYLE_A, DOYLE_B, q * ONES, 1).gain, [[f, f]], rtol=1e-11)
    np.testing.assert_allclose(lqe(DOYLE_A, [[1], [1]], DOYLE_C, q, 1).gain, [[f], [f]], rtol=1e-11)


def test_double_integrator_has_the_butterworth_gain():
    optimal = lqr([[0, 1], [0, 0]], [[0], [1]], np.diag([1, 0]), 1)
    np.testing.assert_allclose(optimal.gain, [[1, np.sqrt(2)]], rtol=1e-13)
    np.testing.assert_allclose(optimal.solution, [[np.sqrt(2), 1], [1, np.sqrt(2)]], rtol=1e-13)
    np.testing.assert_allclose(optimal.poles, np.sqrt(0.5) * np.array([-1 - 1j, -1 + 1j]), rtol=1e-13)


@settings(max_examples=60)
@given(a=st.floats(-5, 5), b=st.floats(0.1, 5), q=st.floats(1e-3, 1e3), r=st.floats(1e-3, 1e3))
def test_scalar_regulator_and_filter_have_their_closed_form(a, b, q, r):
    """K = (a + √(a² + b²q/r))/b: written without cancellation for a < 0."""
    root = np.hypot(a, b * np.sqrt(q / r))
    exact = (a + root) / b if a >= 0 else b * q / r / (root - a)
    assert lqr(a, b, q, r).gain.item() == pytest.approx(exact, rel=1e-9)
    assert lqe(a, 1, b, q, r).gain.item() == pytest.approx(exact, rel=1e-9)


def test_matlab_kalman_example_gives_both_gains():
    A = np.array([[1.1269, -0.4940, 0.1129], [1, 0, 0], [0, 1, 0]])
    kalman = dlqe(A, [[-0.3832], [0.5919], [0.5191]], [[1, 0, 0]], 2.3, 1)
    np.testing.assert_allclose(kalman.filter_gain.ravel(), [0.5345, 0.0101, -0.4776], atol=5e-5)
    np.testing.assert_allclose(kalman.gain, A @ kalman.filter_gain, rtol=1e-12)
    np.testing.assert_array_equal(kalman.predictor_gain, kalman.gain)


def test_scalar_filter_of_a_random_walk():
    """P = W/2 + √(W²/4 + WV): the golden ratio for W = V = 1."""
    golden = (1 + np.sqrt(5)) / 2
    walk = dlqe(1, 1, 1, 1, 1)
    assert walk.solution.item() == pytest.approx(golden, rel=1e-14)
    assert walk.filter_gain.item() == pytest.approx(golden - 1, rel=1e-14)
    assert walk.filtered.item() == pytest.approx(golden - 1, rel=1e-14)


def scipy_cases():
    """The CAREX and DAREX collections of SciPy's own tests, read in a process whose pytest markers are not strict."""
    code = (
        "import pickle, sys; from scipy.linalg.tests import test_solvers as t; "
        "kinds = [getattr(t, f'TestSolve{time}Are', None) for time in ('Continuous', 'Discrete')]; "  # none before SciPy 1.14
        "sys.stdout.buffer.write(pickle.dumps([getattr(kind, 'cases', []) for kind in kinds]))"
    )
    return pickle.loads(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True).stdout)


def real_cases(cases):
    """SciPy's CAREX or DAREX cases that are regulator problems: real, Q ≥ 0, R > 0, at most 30 states."""
    chosen = []
    for number, (A, B, Q, R, _) in enumerate(cases):
        A, B, Q, R = (np.atleast_2d(np.asarray(M)) for M in (A, B, Q, R))
        real = not any(np.iscomplexobj(M) for M in (A, B, Q, R)) and A.shape[0] <= 30
        if real and np.linalg.eigvalsh(Q)[0] >= -1e-10 * np.abs(Q).max() and np.linalg.eigvalsh(R)[0] > 0:
            chosen.append(pytest.param(A, B, Q, R, id=str(number)))
    return chosen


CAREX, DAREX = map(real_cases, scipy_cases())


@pytest.mark.skipif(tuple(map(int, scipy.__version__.split(".")[:2])) < (1, 14), reason="SciPy keeps them within a function")
def test_the_benchmark_collections_are_there():
    assert len(CAREX) >= 11 and len(DAREX) >= 13


@pytest.mark.parametrize(("A", "B", "Q", "R"), CAREX)
def test_carex(A, B, Q, R):
    optimal = lqr(A, B, Q, R)
    S, K = optimal.solution, optimal.gain
    quadratic = K.T @ R @ K
    residual = A.T @ S + S @ A + Q - quadratic
    size = 2 * np.linalg.norm(S @ A) + np.linalg.norm(Q) + np.linalg.norm(quadratic)
    assert np.linalg.norm(residual) <= 1e-9 * size
    assert np.linalg.eigvalsh(S)[0] >= -1e-9 * np.linalg.norm(S)
    assert np.all(np.linalg.eigvals(A - B @ K).real < 0)


@pytest.mark.parametrize(("A", "B", "Q", "R"), DAREX)
def test_darex(A, B, Q, R):
    optimal = dlqr(A, B, Q, R)
    S, K = optimal.solution, optimal.gain
    quadratic = K.T @ (R + B.T @ S @ B) @ K
    residual = A.T @ S @ A - S + Q - quadratic
    size = np.linalg.norm(A.T @ S @ A) + np.linalg.norm(S) + np.linalg.norm(quadratic)
    assert np.linalg.norm(residual) <= 1e-12 * size
    assert np.all(np.abs(np.linalg.eigvals(A - B @ K)) < 1)


@pytest.mark.slow
def test_no_pencil_is_lost_to_a_failed_reordering():
    """QZ's reordering fails now and then on harmless pencils: a pole on a cart, sampled, with many beliefs about its noise."""
    A, G = np.zeros((4, 4)), np.array([[0.0], [0.0], [2.0], [-6.7]])
    A[0, 2] = A[1, 3] = 1.0
    A[2, 1:3], A[3, 1:3] = (-3.9, -0.2), (45.8, 0.67)
    A_d, Q = discretise(Plant(A, G, np.eye(2, 4)), 0.047).A, step_covariance(A, G @ G.T, 0.047)
    for q, r1, r2 in 10.0 ** np.random.default_rng(0).uniform(-4, 4, (400, 3)):
        assert dlqe(A_d, np.eye(4), np.eye(2, 4), q * Q, np.diag([r1, r2])).residual < 1e-13


# --- laws ----------------------------------------------------------------------------------------------------------


def residual_of_the_rounded(A, B, Q, R, S):
    """Relative residual of the exact solution, by Newton's steps from S in fifty digits, once it is rounded to doubles: none has less."""
    with mp.workdps(50):
        a, b, q, s = (mp.matrix(each.tolist()) for each in (A, B, Q, S))
        r = mp.inverse(mp.matrix(R.tolist()))
        n = len(A)
        for _ in range(3):
            K = r * b.T * s
            F, stage = a - b * K, q + K.T * mp.matrix(R.tolist()) * K
            table, right = mp.matrix(n * n), mp.matrix(n * n, 1)
            for i in range(n):
                for j in range(n):
                    for k in range(n):
                        table[i * n + j, k * n + j] += F[k, i]
                        table[i * n + j, i * n + k] += F[k, j]
                    right[i * n + j] = -stage[i, j]
            found = mp.lu_solve(table, right)
            s = mp.matrix([[found[i * n + j] for j in range(n)] for i in range(n)])
        s = mp.matrix([[float(s[i, j]) for j in range(n)] for i in range(n)])
        terms = s * a, q, s * b * r * b.T * s
        left = a.T * s + s * a + q - terms[2]
        return float(mp.mnorm(left, "f") / (2 * mp.mnorm(terms[0], "f") + mp.mnorm(q, "f") + mp.mnorm(terms[2], "f")))


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 8), m=st.integers(1, 3))
@example(seed=168, n=6, m=1)  # the exact solution, rounded, has 1.6e-12, ours 2.3e-12, SciPy's 2.5e-8
def test_the_solution_is_the_cost_of_the_loop_it_makes(seed, n, m):
    """S is also the Lyapunov solution for the closed loop, whose cost xᵀSx no other gain nearby undercuts."""
    A, B = pair(seed, n, m)
    Q, R = weight(seed + 1, n, 0.1), weight(seed + 2, m, 0.1)
    optimal = lqr(A, B, Q, R)

    def cost(K):
        return solve_continuous_lyapunov((A - B @ K).T, -(Q + K.T @ R @ K))

    scale = np.linalg.norm(optimal.solution)
    np.testing.assert_allclose(optimal.solution, cost(optimal.gain), rtol=0, atol=1e-7 * scale)
    nudge = 1e-3 * np.random.default_rng(seed + 3).standard_normal((m, n))
    assert np.linalg.eigvalsh(cost(optimal.gain + nudge) - optimal.solution)[0] > -1e-7 * scale
    assert optimal.residual < 1e-12 or optimal.residual < 2 * residual_of_the_rounded(A, B, Q, R, optimal.solution)


def summed(M, stage):
    """Σ (Mᵀ)ᵏ stage Mᵏ by doubling: SciPy's solution through a bilinear map loses six digits more on these loops (60-digit sums).

    In long doubles: in doubles the sum itself loses ten digits where a gain is large (seed 1280: 7e-6, our S 8e-8).
    """
    M, stage = M.astype(np.longdouble), stage.astype(np.longdouble)
    while np.linalg.norm(M) > 1e-30:
        stage, M = stage + M.T @ stage @ M, M @ M
    return stage.astype(float)


@settings(max_examples=40)
@example(seed=1280, n=6, m=1)
@example(seed=5778, n=6, m=1)  # gains of a hundred and a cost of 6e7
@example(seed=188, n=7, m=1)
@example(seed=8590, n=7, m=1)  # a cost of 1e12: the solution of scipy is off by 8e-5
@given(seed=st.integers(0, 10_000), n=st.integers(1, 7), m=st.integers(1, 3))
def test_the_discrete_solution_is_the_cost_of_the_loop_it_makes(seed, n, m):
    A, B = pair(seed, n, m)
    Q, R = weight(seed + 1, n, 0.1), weight(seed + 2, m, 0.1)
    N = 0.05 * np.random.default_rng(seed).standard_normal((n, m))
    Q = Q + N @ np.linalg.solve(R, N.T)
    optimal = dlqr(A, B, Q, R, N=N)
    K, S = optimal.gain, optimal.solution
    stage, B, K = (M.astype(np.longdouble) for M in (Q, B, K))
    stage = stage - N @ K - K.T @ N.T + K.T @ R @ K
    cost = summed(A - B @ K, stage)
    B, K = B.astype(float), K.astype(float)
    lost = max(np.linalg.norm(S) / (1e8 * np.linalg.norm(Q)), 1.0)  # digits that a plant which the input hardly reaches costs any solver
    np.testing.assert_allclose(S, cost, rtol=0, atol=1e-7 * lost * np.linalg.norm(S))
    np.testing.assert_allclose(np.linalg.eigvals(A - B @ K).astype(complex).sum(), optimal.poles.sum(), atol=1e-9)


@settings(max_examples=30)
@given(seed=st.integers(0, 10_000), n=st.integers(1, 6), p=st.integers(1, 3))
def test_the_filter_covariance_balances_noise_and_correction(seed, n, p):
    """(A − LC)P + P(A − LC)ᵀ + GWGᵀ + LVLᵀ = 0, the covariance equation of ė = (A − LC)e + Gw − Lv."""
    A, C = pair(seed, n, p)
    C, (G, _) = C.T, pair(seed + 5, n, 1)
    W, V = weight(seed + 1, n, 0.1), weight(seed + 2, p, 0.1)
    kalman = lqe(A, G, C, W, V)
    L, P = kalman.gain, kalman.solution
    closed = A - L @ C
    balance = closed @ P + P @ closed.T + G @ W @ G.T + L @ V @ L.T
    assert np.linalg.norm(balance) < 1e-9 * (np.linalg.norm(G @ W @ G.T) + np.linalg.norm(L @ V @ L.T))
    assert L.shape == (n, p)


def test_the_discrete_filter_is_the_fixed_point_of_the_recursion():
    A, C = pair(4, 4, 2)
    C, G = C.T, np.eye(4)[:, :2]
    kalman = dlqe(A, G, C, np.diag([1.0, 2.0]), np.diag([0.5, 3.0]))
    P = np.eye(4)
    for _ in range(500):
        M = P @ C.T @ np.linalg.inv(C @ P @ C.T + np.diag([0.5, 3.0]))
        filtered = P - M @ C @ P
        P = A @ filtered @ A.T + G @ np.diag([1.0, 2.0]) @ G.T
    np.testing.assert_allclose(kalman.solution, P, rtol=1e-8)
    np.testing.assert_allclose(kalman.filter_gain, M, rtol=1e-8)
    np.testing.assert_allclose(kalman.filtered, filtered, rtol=1e-7, atol=1e-9)


@pytest.mark.parametrize("alpha", [1e-30, 1e-24, 1e-18, 1e-12, 1e-6, 1e3, 1e6, 1e12])
def test_a_common_factor_of_the_weights_leaves_the_gain_alone(alpha):
    A, B = pair(7, 6, 2)
    Q, R = weight(1, 6, 0.1), weight(2, 2, 0.1)
    for design in (lqr, dlqr):
        plain, scaled = design(A, B, Q, R), design(A, B, alpha * Q, alpha * R)
        np.testing.assert_allclose(scaled.gain, plain.gain, rtol=1e-10)
        np.testing.assert_allclose(scaled.solution, alpha * plain.solution, rtol=1e-10)
    for design in (lqe, dlqe):
        plain, scaled = design(A, B, B.T, R, R), design(A, B, B.T, alpha * R, alpha * R)
        np.testing.assert_allclose(scaled.gain, plain.gain, rtol=1e-10)


@pytest.mark.parametrize("power", range(-100, 101, 25))
def test_a_power_of_two_leaves_the_gain_alone_to_the_last_bit(power):
    A, B = pair(8, 5, 2)
    Q, R = weight(1, 5, 0.1), weight(2, 2, 0.1)
    np.testing.assert_array_equal(lqr(A, B, Q * 4.0**power, R * 4.0**power).gain, lqr(A, B, Q, R).gain)


def test_the_platforms_noise_levels_are_no_obstacle():
    """W = 1e-12 and V = 1e-18, where python-control's lqe gives up: resonant modes seen through their velocity."""
    rows = [np.array([[0, 1], [-(w**2), -2 * 0.01 * w]]) for w in (3.0, 11.0, 40.0)]
    A = np.zeros((6, 6))
    for i, row in enumerate(rows):
        A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = row
    G, C = np.kron(np.ones((3, 1)), [[0.0], [1.0]]), np.kron(np.ones((1, 3)), [[0.0, 1.0]])
    small, unit = lqe(A, G, C, 1e-12, 1e-18), lqe(A, G, C, 1.0, 1e-6)
    np.testing.assert_allclose(small.gain, unit.gain, rtol=1e-10, atol=1e-10 * np.abs(unit.gain).max())
    assert small.residual < 1e-12
    with mp.workdps(40):
        P, M = mp.matrix(unit.solution.tolist()), mp.matrix(A.tolist())
        c, g = mp.matrix(C.tolist()), mp.matrix(G.tolist())
        rest = M * P + P * M.T - P * c.T * c * P * mp.mpf(10) ** 6 + g * g.T
        assert float(mp.mnorm(rest, "f")) < 1e-8


def test_cheap_control_tends_to_the_mirrored_poles():
    """Without a state weight the optimal poles are the unstable ones mirrored at the axis."""
    A, B = np.diag([1.0, -2.0]), np.ones((2, 1))
    np.testing.assert_allclose(lqr(A, B, np.zeros((2, 2)), 1).poles, [-2, -1], atol=1e-12)
    np.testing.assert_allclose(dlqr(np.diag([2.0, 0.3]), B, np.zeros((2, 2)), 1).poles, [0.3, 0.5], atol=1e-12)


def test_singular_A_is_no_obstacle_in_discrete_time():
    """A pure delay line: A is nilpotent, the classical symplectic matrix does not exist."""
    A, B = np.eye(3, k=1), np.eye(3)[:, -1:]
    optimal = dlqr(A, B, np.eye(3), 1)
    np.testing.assert_allclose(optimal.gain, 0, atol=1e-14)
    np.testing.assert_allclose(optimal.solution, np.diag([1, 2, 3]), rtol=1e-13, atol=1e-14)


def test_the_symplectic_way_agrees_with_the_pencil(monkeypatch):
    """On sampled plants, with cross weights and poles close to the circle; where A has no good inverse it does not answer."""
    problems, found = [], []
    for seed in range(12):
        A, B = pair(seed, 2 + seed % 7, 1 + seed % 2)
        n, m = B.shape
        A, N = discretise(Plant(A, B, np.eye(n)), 10.0 ** -(1 + seed % 3)).A, 0.05 * np.ones((n, m))
        problems.append(riccati.RiccatiProblem(A, B, weight(seed, n, 0.5), weight(seed + 1, m, 0.5), N))
    for problem in problems:
        assert riccati.by_symplectic(problem) is not None
        found.append(riccati.solve_discrete(problem))
    assert riccati.by_symplectic(riccati.RiccatiProblem(np.diag([0.5, 1e-9]), ONES, ONES + np.eye(2), np.eye(2), 0 * ONES)) is None
    monkeypatch.setattr(riccati, "by_symplectic", lambda problem: None)
    for problem, (S, K, residual, _) in zip(problems, found, strict=True):
        pencil = riccati.solve_discrete(problem)
        np.testing.assert_allclose(S, pencil[0], rtol=0, atol=1e-9 * np.abs(S).max())
        np.testing.assert_allclose(K, pencil[1], rtol=0, atol=1e-9 * np.abs(K).max())
        assert residual <= max(2e-15, pencil[2])


def test_cross_weight_equals_a_change_of_input():
    """With v = u + R⁻¹Nᵀx the cross term is gone: K = K_v + R⁻¹Nᵀ."""
    A, B = pair(9, 4, 2)
    R, N = weight(2, 2, 0.5), 0.1 * np.ones((4, 2))
    shift = np.linalg.solve(R, N.T)
    Q = weight(1, 4, 1.0)
    np.testing.assert_allclose(
        lqr(A, B, Q + N @ shift, R, N=N).gain, lqr(A - B @ shift, B, Q, R).gain + shift, rtol=1e-9, atol=1e-10
    )


# --- refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("design", "sentence"),
    [
        (lambda: lqr(np.diag([1.0, -1.0]), [[0], [1]], np.eye(2), 1), "mode at 1 is not stable and is uncontrollable"),
        (lambda: lqe(np.diag([1.0, -1.0]), np.eye(2), [[0, 1]], np.eye(2), 1), "mode at 1 .* unobservable: no L"),
        (lambda: lqr([[0, 1], [0, 0]], [[0], [1]], np.diag([0, 1]), 1), "mode at 0 lies on the stability boundary"),
        (lambda: lqe(0, 1, 1, 0, 1), "mode at 0 lies on the stability boundary and the noise w does not excite it"),
        (lambda: dlqr(np.diag([2.0, 0.5]), [[0], [1]], np.eye(2), 1), "mode at z = 2 is not stable and is uncontrollable"),
        (lambda: dlqr(1, 1, 0, 1), "mode at z = 1 lies on the stability boundary"),
    ],
)
def test_problems_without_a_stabilising_gain_name_the_mode(design, sentence):
    with pytest.raises(RiccatiError, match=sentence):
        design()


@pytest.mark.parametrize(
    ("Q", "R", "sentence"),
    [
        (-np.eye(2), 1, "Q has a negative eigenvalue"),
        ([[1, 2], [0, 1]], 1, "Q must be symmetric"),
        (np.eye(2), 0, "R must be positive definite"),
        (np.eye(2), -1, "R has a negative eigenvalue"),
        ([[np.nan, 0], [0, 1]], 1, "NaN"),
    ],
)
def test_weights_that_are_no_weights_are_refused(Q, R, sentence):
    with pytest.raises(EngineError, match=sentence):
        lqr(DOYLE_A, DOYLE_B, Q, R)


def test_shapes_that_do_not_fit_are_refused():
    for call in (
        lambda: lqr(DOYLE_A, DOYLE_B, np.eye(3), 1),
        lambda: lqr(DOYLE_A, DOYLE_B, np.eye(2), np.eye(2)),
        lambda: lqr(DOYLE_A, np.ones((3, 1)), np.eye(2), 1),
        lambda: lqr(DOYLE_A, DOYLE_B, np.eye(2), 1, N=np.ones((1, 2))),
        lambda: lqe(DOYLE_A, np.ones((3, 1)), DOYLE_C, 1, 1),
        lambda: lqe(DOYLE_A, DOYLE_B, np.ones((1, 3)), 1, 1),
        lambda: lqr(np.ones((2, 3)), DOYLE_B, np.eye(2), 1),
    ):
        with pytest.raises(ShapeError):
            call()


def test_a_cross_weight_that_makes_the_cost_indefinite_is_refused():
    with pytest.raises(EngineError, match="N R⁻¹ Nᵀ"):
        lqr(DOYLE_A, DOYLE_B, np.eye(2), 1, N=10 * np.ones((2, 1)))
