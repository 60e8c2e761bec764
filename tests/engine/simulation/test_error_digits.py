"""The error of a run without limits is run itself: a large observer gain takes no digits from it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from observer_lab.engine import Plant, Scenario, observer_gain, simulate
from observer_lab.engine.simulation import autonomous_error, separation_meter


def _loop(seed: int, speed: float, **more) -> Scenario:
    rng = np.random.default_rng(seed)
    n = 4
    plant = Plant(rng.standard_normal((n, n)), rng.standard_normal((n, 1)), rng.standard_normal((1, n)))
    L = observer_gain(plant.A, plant.C, -speed * np.arange(1.0, n + 1)).gain
    return Scenario(plant, K=np.zeros((1, n)), L=L, x0=rng.standard_normal(n), horizon=1.0, dt=0.01,
                    reference=1e6 * np.ones((101, 1)), **more)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("speed", [1.0, 4.0])
def test_e_does_not_feel_the_input_however_large_L_is(seed: int, speed: float) -> None:
    """x is some 1e6 times e(0), and ‖L‖ up to 1e4: on (x, x̂) the difference would be rounding of L C x."""
    s = _loop(seed, speed)
    run, quiet = simulate(s), simulate(replace(s, reference=None, x0=np.zeros(4), xhat0=-s.x0))
    assert np.abs(run.e - quiet.e).max() < 1e-8 * np.abs(quiet.e).max()  # two scans, each with its rounding
    assert separation_meter(run) < 1e-9
    np.testing.assert_allclose(run.x - run.xhat, run.e, atol=1e-9 * np.abs(run.xhat).max())


def _power(M: np.ndarray, t: float) -> np.ndarray:
    """exp(M t) in extended precision: Taylor's series over a short time, squared."""
    part = M.astype(np.longdouble) * np.longdouble(t)
    halvings = 4 + max(0, int(np.ceil(np.log2(float(np.abs(part).sum(axis=1).max()) + 1e-9))))
    total = term = np.eye(len(M), dtype=np.longdouble)
    for k in range(1, 24):
        term = term @ part / 2**halvings / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total.astype(float)


@pytest.mark.parametrize("seed", range(4))
def test_e_is_that_of_its_own_equation(seed: int) -> None:
    s = _loop(seed, 2.0)
    run = simulate(s)
    exact = np.array([_power(s.plant.A - s.L @ s.plant.C, t) @ run.e[0] for t in run.t[::20]])
    np.testing.assert_allclose(run.e[::20], exact, atol=1e-11 * np.abs(run.e).max())


@pytest.mark.parametrize("changes", [
    {}, {"W": [[0.1]], "G": np.ones((4, 1)), "V": [[0.1]]}, {"impulses": ((0.123, np.ones(4)), (0.5, np.ones(4)))}, {"sampled": True},
    {"sampled": True, "V": [[0.1]]}])
def test_runs_with_and_without_limits_that_never_act_agree(changes: dict[str, object]) -> None:
    """The clipped loop runs on (x, x̂): with limits out of reach it must say the same."""
    s = _loop(5, 3.0, **changes)
    s = replace(s, reference=None)
    plain, clipped = simulate(s), simulate(replace(s, u_min=-1e12, u_max=1e12))
    for one, other in ((plain.x, clipped.x), (plain.xhat, clipped.xhat), (plain.e, clipped.e), (plain.y, clipped.y)):
        np.testing.assert_allclose(one, other, rtol=1e-7, atol=1e-8 * np.abs(clipped.xhat).max())
    gap = np.abs(autonomous_error(plain) - plain.e).max()
    assert gap < 1e-10 * np.abs(plain.e).max()


def test_a_wrong_model_drives_the_error_as_in_the_loop_of_both() -> None:
    s = _loop(6, 2.0)
    p = s.plant
    s = replace(s, model=Plant(1.1 * p.A, 0.9 * p.B, p.C), K=0.1 * np.ones((1, 4)), reference=None)
    plain, clipped = simulate(s), simulate(replace(s, u_min=-1e12, u_max=1e12))
    np.testing.assert_allclose(plain.e, clipped.e, rtol=1e-6, atol=1e-8 * np.abs(clipped.xhat).max())
