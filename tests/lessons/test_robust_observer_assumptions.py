"""What the paper on robust observers assumes: runs by scipy's integrator, ranks by python-control and by Popov's test, T = 0."""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from observer_lab.engine import EngineError, functional_observer
from observer_lab.lessons.robust_observer.assumptions import DT, HORIZON, MODE_RAD_S, X0, assumed_run
from observer_lab.lessons.robust_observer.knobs import ASSUMED, KEPT, STATIC, STATIC_FIT, UNREACHED, UNSEEN
from observer_lab.lessons.robust_observer.lesson import LESSON
from observer_lab.plants.duan import outer_input

CASES = [name for name, _ in ASSUMED]


def tab(case: str) -> dict[str, Any]:
    figures = LESSON.figures(LESSON.compute(LESSON.apply(LESSON.start(), {"assumed": case})))
    return {figure.id: figure for figure in figures if figure.id.startswith("assumed")}


@pytest.mark.parametrize("case", CASES)
def test_each_case_runs_as_scipys_integrator_says(case: str) -> None:
    one = assumed_run(case)
    A, B, C, q = one.plant.A, one.plant.B, one.plant.C, len(one.F)

    def rates(t: float, s: np.ndarray) -> np.ndarray:
        x, z = s[:3], s[3:]
        y = C @ x
        u = outer_input(t) - (one.N @ z + one.M @ y)
        return np.concatenate([A @ x + B @ u, one.F @ z + one.L @ y + one.T @ B @ u])

    run = solve_ivp(rates, (0, HORIZON), [*X0, *np.zeros(q)], t_eval=one.t, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(one.x, run.y[:3].T, atol=1e-6)
    np.testing.assert_allclose(one.e_u, (one.K @ run.y[:3] - one.N @ run.y[3:] - one.M @ C @ run.y[:3])[0], atol=1e-6)
    assert len(one.t) == round(HORIZON / DT) + 1 and q == {KEPT: 2, UNREACHED: 2, UNSEEN: 1}.get(case, 0)


def test_the_table_has_the_ranks_of_python_control_and_the_mode_fails_popovs_test_where_it_is_hidden() -> None:
    for case in CASES:
        plant, rows = assumed_run(case).plant, tab(case)["assumed"].rows
        assert [row[1] for row in rows[:2]] == [f"{np.linalg.matrix_rank(M)} / 3" for M in (
            control.ctrb(plant.A, plant.B), control.obsv(plant.A, plant.C))]
        pencil = plant.A - MODE_RAD_S * np.eye(3)
        assert (np.linalg.matrix_rank(np.hstack([pencil, plant.B])) < 3) == (case == UNREACHED)
        assert (np.linalg.matrix_rank(np.vstack([pencil, plant.C])) < 3) == (case == UNSEEN)


def test_without_a_sensor_on_the_mode_no_order_gives_K_and_the_engine_says_so() -> None:
    one = assumed_run(UNSEEN)
    share = abs(one.K[0, 2]) / np.linalg.norm(one.K)
    assert [row[1] for row in tab(UNSEEN)["assumed"].rows[3:]] == [f"{100 * share:.3g} %"] * 2
    for order in (1, 2, 3):
        with pytest.raises(EngineError):
            functional_observer(one.plant, one.K, order, poles=[-2.0, -3.0, -4.0][:order])


def test_without_an_input_on_the_mode_the_estimate_is_right_and_no_gain_moves_the_pole() -> None:
    one, rng = assumed_run(UNREACHED), np.random.default_rng(5)
    assert np.abs(one.e_u[-200:]).max() < 1e-4 * np.abs(one.e_u).max() and abs(one.x[-1, 2]) == pytest.approx(0.3 * np.exp(0.3 * 8))
    for K in rng.normal(0, 10, (20, 1, 3)):
        assert np.abs(np.linalg.eigvals(one.plant.A - one.plant.B @ K) - MODE_RAD_S).min() < 1e-9
    assert "unstable" in tab(UNREACHED)["assumed_mode"].caption("en") and "stable" in tab(KEPT)["assumed_mode"].caption("en")


def test_without_a_state_K_must_be_a_multiple_of_C() -> None:
    """u = −My: the nearest M by least squares misses K by the sine of the angle between K and C."""
    one = assumed_run(STATIC)
    k, c = one.K[0], one.plant.C[0]
    sine = np.sqrt(1 - (k @ c) ** 2 / (k @ k) / (c @ c))
    assert tab(STATIC)["assumed"].rows[2][1] == f"{100 * sine:.3g} %"
    np.testing.assert_allclose(one.M, np.linalg.lstsq(one.plant.C.T, one.K.T, rcond=None)[0].T)
    np.testing.assert_allclose(one.e_u, one.x @ (one.K - one.M @ one.plant.C)[0], atol=1e-12)
    assert np.abs(one.e_u[-200:]).max() > 0.1 and np.all(one.loop.real < 0)
    exact = assumed_run(STATIC_FIT)
    assert np.all(exact.e_u == 0) and exact.T.shape == (0, 3) and "no error at any time" in tab(STATIC_FIT)["assumed_error"].caption("en")
