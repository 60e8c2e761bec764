"""Figure 11 of the report on the page: its spectra against transfer functions by numpy and scipy."""

from functools import lru_cache

import numpy as np
import pytest
from scipy.linalg import cholesky, expm, solve_continuous_lyapunov, solve_discrete_are, svd

from observer_lab.lessons.kalman.figure_eleven import eleven
from observer_lab.lessons.kalman.lesson import LESSON
from observer_lab.plants.platform import model

DT, SHAPE = 1e-3, np.array([1.0, 1.0, 0.5])
A, B, C = model.mechanics().matrices()


def truncated() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eight balanced states, by the square-root method; HR repeats HL, and C has rank three."""
    reach, seen = solve_continuous_lyapunov(A, -B @ B.T), solve_continuous_lyapunov(A.T, -C.T @ C)
    left, right = (cholesky(X + 1e-16 * np.trace(X) * np.eye(10), lower=True) for X in (reach, seen))
    U, s, V = svd(right.T @ left)
    T, inverse = left @ V[:8].T / np.sqrt(s[:8]), (right @ U[:, :8] / np.sqrt(s[:8])).T
    return inverse @ A @ T, inverse @ B, C @ T


def sampled(A: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """e^{A dt}, the held coils, and the covariance that the ground's 10⁻¹² adds in a step (Van Loan)."""
    n = len(A)
    held = expm(DT * np.block([[A, B[:, :3]], [np.zeros((3, n + 3))]]))
    loan = expm(DT * np.block([[-A, 1e-12 * B[:, 3:] @ B[:, 3:].T], [np.zeros((n, n)), A.T]]))
    F = loan[n:, n:].T
    return F, held[:n, n:], F @ loan[:n, n:]


@lru_cache(maxsize=4)
def gain(q: float, r: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The filter's step, its readings and its steady gain M."""
    a, b, c = truncated()
    Fr, _, Qr = sampled(a, b)
    R = r * 1e-12 * np.eye(4)
    P = 1e-12 * q * solve_discrete_are(Fr.T, c.T, Qr * 1e12, R / (1e-12 * q))
    return Fr, c, P @ c.T @ np.linalg.inv(c @ P @ c.T + R)


def responses(q: float, r: float, f: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """At f: response of the outputs to the coils, of the error where the filter is not given them, and density of the error."""
    F, H, Q = sampled(A, B)
    Fr, c, M = gain(q, r)
    z = np.exp(2j * np.pi * f * DT)
    states = np.linalg.inv(z * np.eye(10) - F)
    # x̂⁺ = (I − M c)(Fr x̂⁺ of the last sample + Hr u) + M y
    corrected = (np.eye(8) - M @ c) @ Fr
    estimate = np.linalg.solve(np.eye(8) - corrected / z, M)
    from_y = c @ estimate
    leave = np.eye(4) - from_y
    noise = leave @ C @ states
    density = 2 * DT * np.real(np.diag(noise @ Q @ noise.conj().T + 1e-12 * from_y @ from_y.conj().T))
    return C @ states @ H @ SHAPE, leave @ C @ states @ H @ SHAPE, density


@pytest.mark.parametrize(("q", "r"), [(1.0, 1.0), (0.01, 1.0), (1.0, 100.0)])
def test_the_spectra_are_those_of_the_transfer_functions(q: float, r: float) -> None:
    found = eleven(q, r, 1.0, 1)
    assert found.f[found.at] == pytest.approx(0.16, abs=1e-9)
    answer, unaware, _ = responses(q, r, 0.16)
    ratio = np.abs(unaware) ** 2 / np.abs(answer) ** 2
    assert found.unaware[found.at] / found.outputs[found.at] == pytest.approx(ratio, rel=0.15)
    band = np.flatnonzero((found.f > 5) & (found.f < 40))
    predicted = np.array([responses(q, r, f)[2] for f in found.f[band[::10]]]).mean(axis=0)
    assert found.errors[band].mean(axis=0) == pytest.approx(predicted, rel=0.15)


@pytest.mark.parametrize(("q", "r"), [(1.0, 1.0), (0.01, 1.0), (1.0, 100.0), (100.0, 0.01)])
def test_the_known_force_leaves_no_peak_even_with_wrong_covariances(q: float, r: float) -> None:
    """So the report's figure is right, and says nothing about Q and R."""
    found = eleven(q, r, 1.0, 1)
    assert found.errors[found.at] / found.quiet[found.at] == pytest.approx(np.ones(4), abs=0.05)
    near = found.errors[found.at] / np.sqrt(found.errors[found.at - 1] * found.errors[found.at + 1])
    assert (near < 30).all()
    assert (found.unaware[found.at] > 1e4 * found.quiet[found.at]).all() == (q / r < 1e3)  # beyond it follows its sensors


@pytest.mark.parametrize(("values", "words"), [({}, "given the force"), ({"force": 0.0}, "No known force"),
                                             ({"q": 100.0}, "given the force"),
                                             ({"q": 100.0, "r": 0.01}, "follows its sensors")])
def test_the_table_says_what_the_records_show(values: dict, words: str) -> None:
    outcome = LESSON.compute(LESSON.apply(LESSON.start(), values))
    shown = {f.id: f for f in LESSON.figures(outcome) if f.id.startswith("eleven")}
    assert list(shown) == ["eleven-errors", "eleven-outputs", "eleven"] and words in shown["eleven"].caption("en")
    d = outcome.design
    found = eleven(d["q"], d["r"], d["force"], int(d["seed"]))
    printed = [float(row[1].split()[0]) for row in shown["eleven"].table()[1]]
    assert printed == pytest.approx(10 * np.log10(found.outputs[found.at] / found.errors[found.at]), abs=0.6)
    figure = shown["eleven-errors"]
    assert 0.16 in figure.x.round(9) and all((c.y > 0).all() for c in figure.curves)
