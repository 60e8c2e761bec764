"""Reduced-order observers: the error of a run that scipy integrates decays with the poles asked for; noise passes at once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import StateSpace, dlsim, lsim

from observer_lab.engine import EngineError, Plant, Scenario, simulate
from observer_lab.engine.observers import reduced_observer

POLES = (-2.0, -3.0)


def plant(seed: int, dt: float = 0.0) -> Plant:
    """Four states, two outputs that also hear the input."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((4, 4))
    return Plant(A / 4 if dt else A, rng.standard_normal((4, 1)), rng.standard_normal((2, 4)), rng.standard_normal((2, 1)), dt)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("dt", [0.0, 0.1])
def test_the_error_obeys_the_poles_whatever_the_input(seed: int, dt: float) -> None:
    p = plant(seed, dt)
    poles = (0.2, 0.4) if dt else POLES
    o = reduced_observer(p, poles)
    assert o.F.shape == (2, 2)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(o.F).real), np.sort(poles), rtol=1e-7)
    A = np.block([[p.A, np.zeros((4, 2))], [o.G @ p.C, o.F]])
    B = np.vstack([p.B, o.H])
    x0, w0 = np.array([1.0, -2.0, 0.5, 1.5]), np.array([0.3, -0.7])
    t = np.arange(40) * (dt or 0.02)
    u = np.sin(7 * t)[:, None]
    joint = (A, B, np.eye(6), np.zeros((6, 1)))
    z = dlsim((*joint, dt), u, x0=np.append(x0, w0))[1] if dt else lsim(StateSpace(*joint), u, t, np.append(x0, w0))[1]
    x, w = z[:, :4], z[:, 4:]
    e = x - o.estimates(w, x @ p.C.T + u @ p.D.T, u)
    first = o.S @ x0 - w0
    decays = np.array([(np.linalg.matrix_power(o.F, k) if dt else expm(o.F * t[k])) @ first for k in range(len(t))])
    np.testing.assert_allclose(e, decays @ o.M.T, atol=1e-8 * np.abs(x).max())
    np.testing.assert_allclose(e @ p.C.T, 0.0, atol=1e-9 * np.abs(x).max())


def test_a_reading_that_is_wrong_reaches_the_estimate_at_once() -> None:
    p = plant(1)
    o = reduced_observer(p, POLES)
    zero = np.zeros((1, 1))
    jump = o.estimates(np.zeros((1, 2)), np.array([[0.1, 0.0]]), zero)
    np.testing.assert_allclose(jump[0], 0.1 * o.N[:, 0])
    np.testing.assert_allclose(p.C @ o.N, np.eye(2), atol=1e-10)


def test_a_scenario_runs_it_as_its_model() -> None:
    """Without noise the estimate meets the state of the plant's own run."""
    p = plant(2)
    o = reduced_observer(p, (-8.0, -9.0))
    run = simulate(Scenario(p, None, o.G, model=o.model, x0=[1.0, 0, 0, 1.0], horizon=3.0, reference=np.ones((301, 1))))
    found = o.estimates(run.xhat, run.y, run.u_applied)
    assert np.abs(found[0] - run.x[0]).max() > 0.1 and np.abs(found[-1] - run.x[-1]).max() < 1e-6 * np.abs(run.x[-1]).max()


@pytest.mark.parametrize(("C", "words"), [(np.eye(2), "every state"), ([[1.0, 0.0], [2.0, 0.0]], "depend on each other")])
def test_what_leaves_nothing_to_design_is_refused(C: object, words: str) -> None:
    with pytest.raises(EngineError, match=words):
        reduced_observer(Plant([[0, 1], [-1, -1]], [[0], [1]], C), [-3.0])
