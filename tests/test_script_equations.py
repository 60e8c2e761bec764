"""The equations that exported scripts carry with them are solved as the engine solves them, however the weights are scaled."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import schur, solve_continuous_lyapunov

from observer_lab.engine import dlqr, lqr
from observer_lab.export.scripts.literals import template_text


def _library() -> dict[str, object]:
    """The functions of the scripts' library, with the names that the scripts import."""
    space: dict[str, object] = {"np": np, "schur": schur, "solve_continuous_lyapunov": solve_continuous_lyapunov}
    exec(template_text("library"), space)
    return space


def _problem(seed: int) -> tuple[np.ndarray, ...]:
    """A plant in states up to three decades apart, with weights up to twelve decades apart."""
    rng = np.random.default_rng((35, seed))
    n, m = int(rng.integers(2, 9)), int(rng.integers(1, 4))
    d = 10.0 ** rng.uniform(-1.5, 1.5, n)
    A, B = rng.standard_normal((n, n)) * d / d[:, None], rng.standard_normal((n, m)) / d[:, None]
    root = rng.standard_normal((n, n)) * d
    return A, B, root.T @ root * 10.0 ** rng.uniform(-6, 6), np.diag(10.0 ** rng.uniform(-1, 1, m)) * 10.0 ** rng.uniform(-6, 6)


@pytest.mark.parametrize("seed", range(20))
def test_the_scripts_regulator_is_the_engines(seed: int) -> None:
    A, B, Q, R = _problem(seed)
    S = _library()["riccati"](A, B, Q, R)
    K, found = np.linalg.solve(R, B.T @ S), lqr(A, B, Q, R).gain
    assert np.abs(K - found).max() < 1e-6 * np.abs(found).max()


@pytest.mark.parametrize("seed", range(20))
def test_the_scripts_sampled_regulator_is_the_engines(seed: int) -> None:
    A, B, Q, R = _problem(seed)
    A = A / np.abs(np.linalg.eigvals(A)).max() * 1.1
    S = _library()["discrete_riccati"](A, B @ np.linalg.solve(R, B.T), Q)
    K, found = np.linalg.solve(R + B.T @ S @ B, B.T @ S @ A), dlqr(A, B, Q, R).gain
    assert np.abs(K - found).max() < 1e-6 * np.abs(found).max()


def test_no_script_calls_a_bare_solver() -> None:
    """SciPy's solvers refuse what is badly scaled: scripts ask their library."""
    from observer_lab.export.scripts.literals import TEMPLATES_FOLDER

    calls = [path.name for path in (TEMPLATES_FOLDER / "python").rglob("*.txt") if "_are" in path.read_text(encoding="utf-8")]
    assert not calls
