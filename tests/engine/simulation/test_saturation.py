"""Clipped loops: exact between switchings, switchings found, and who is fed what decides the error."""

from typing import Any

import numpy as np
import pytest
from laws import holds_for_all
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from observer_lab.engine import Plant, Scenario, simulate
from observer_lab.engine.simulation import disturbances_of, simulate_until
from observer_lab.engine.simulation.batch import part_step
from observer_lab.engine.simulation.loop import continuous_loop
from observer_lab.engine.simulation.saturation import Switcher

DOUBLE = Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
K, L = np.array([[4.0, 4.0]]), np.array([[12.0], [36.0]])  # poles −2, −2 and −6, −6
ONE = {"u_min": -1, "u_max": 1}


def promised(run) -> np.ndarray:
    return np.array([expm((DOUBLE.A - L @ DOUBLE.C) * t) @ run.e[0] for t in run.t])


def test_fed_the_clipped_input_the_error_stays_autonomous() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[5.0, 0.0], **ONE))
    assert run.saturated and np.abs(run.u_applied).max() == 1.0
    assert np.abs(run.e - promised(run)).max() < 1e-9


def test_fed_the_asked_input_the_error_departs_by_the_published_amount() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[5.0, 0.0], fed="commanded", **ONE))
    assert np.abs(run.e - promised(run)).max() == pytest.approx(7.7, abs=0.05)


def test_switching_instant_of_an_integrator_in_closed_form() -> None:
    run = simulate(Scenario(Plant([[0]], [[1]], [[1]]), K=[[2.0]], x0=[5.003], state_feedback=True, dt=0.25, **ONE))
    t = run.t
    true = np.where(t < 4.503, 5.003 - t, 0.5 * np.exp(-2 * np.clip(t - 4.503, 0, None)))
    assert np.abs(run.x[:, 0] - true).max() < 1e-13


def field(s: Scenario):
    """The loop as a solver sees it, written out by hand."""
    P, n = s.plant, s.plant.n

    def slope(t: float, z: np.ndarray) -> np.ndarray:
        x, xhat = z[:n], z[n:]
        asked = -s.K @ xhat
        u = np.clip(asked, s.u_min, s.u_max)
        fed = u if s.fed == "applied" else asked
        innovation = P.C @ x + P.D @ u - P.C @ xhat - P.D @ fed
        return np.concatenate([P.A @ x + P.B @ u, P.A @ xhat + P.B @ fed + s.L @ innovation])

    return slope


@pytest.mark.parametrize("fed", ["applied", "commanded"])
def test_two_inputs_with_uneven_limits_agree_with_a_tight_solver(fed: str) -> None:
    A = np.array([[0.0, 1, 0, 0], [-4, -0.1, 1, 0], [0, 0, 0, 1], [1, 0, -9, -0.1]])
    plant = Plant(A, [[0, 0], [1, 0.2], [0, 0], [0.1, 1]], [[1, 0, 0, 0], [0, 0, 1, 0]], [[0, 0.1], [0, 0]])
    gain = np.array([[3.0, 3, 0.5, 0], [0.5, 0, 2, 3]])
    observer = np.array([[6.0, 0], [8, 1], [0, 5], [1, 4]])
    s = Scenario(plant, gain, observer, x0=[2, 0, -1, 1], u_min=[-0.5, -np.inf], u_max=[1.0, 0.7], fed=fed, horizon=8)
    run = simulate(s)
    start = [2, 0, -1, 1, 0, 0, 0, 0]
    peer = solve_ivp(field(s), (0, 8), start, "DOP853", run.t, rtol=1e-12, atol=1e-13, max_step=0.01)
    assert run.saturated
    assert np.abs(np.hstack([run.x, run.xhat]) - peer.y.T).max() < 1e-8


@pytest.mark.parametrize("fed", ["applied", "commanded"])
def test_coarse_and_fine_grids_agree_so_no_switching_is_missed(fed: str) -> None:
    oscillator = Plant([[0, 1], [-100, 0]], [[0], [1]], [[1, 0]])
    for x0 in ([1.0, 0.0], [0.31, 1.7], [0.02, 9.0]):
        runs = [simulate(Scenario(oscillator, [[0.0, 2.0]], [[8.0], [-30.0]], x0=x0, horizon=6, dt=dt, fed=fed,
                                  impulses=((2.303, [0.0, 5.0]),), **ONE)) for dt in (0.5, 0.005)]
        assert runs[1].saturated
        assert np.abs(runs[0].x - runs[1].x[::100]).max() < 1e-10


def test_stiff_observer_behind_a_limit_agrees_with_a_finer_grid() -> None:
    fast = np.array([[2e4], [1e8]])
    runs = [simulate(Scenario(DOUBLE, K, fast, x0=[1.0, 0.0], horizon=4, dt=dt, **ONE)) for dt in (0.04, 0.004)]
    assert np.abs(runs[0].x - runs[1].x[::10]).max() < 1e-9


def test_limits_never_reached_change_nothing() -> None:
    noise = {"x0": [1.0, 0.0], "W": 1e-3, "V": 1e-4, "impulses": ((1.003, [0.0, 1.0]),)}
    free, wide = simulate(Scenario(DOUBLE, K, L, **noise)), simulate(Scenario(DOUBLE, K, L, u_max=1e5, **noise))
    assert not wide.saturated and np.abs(free.x - wide.x).max() < 1e-12


def test_start_exactly_on_a_limit() -> None:
    for x0 in ([0.25, 0.0], [-0.25, 0.0]):
        run = simulate(Scenario(DOUBLE, K, L, x0=x0, xhat0=x0, **ONE))
        assert not run.saturated and run.x[0, 0] == x0[0]
        assert np.abs(run.x[-1]).max() < 1e-6


def test_noise_that_switches_at_every_step_stays_autonomous_and_within_limits() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], V=1.0, u_min=-0.1, u_max=0.1, horizon=3, seed=5))
    quiet = simulate(Scenario(DOUBLE, K, L, x0=[1.0, 0.0], V=1.0, horizon=3, seed=5))
    assert np.abs(run.u_applied).max() <= 0.1
    assert np.abs(run.e - quiet.e).max() < 1e-11


LOOP = continuous_loop(Scenario(DOUBLE, K, L, **ONE))


def stiff(seed: int) -> Scenario:
    """A plant whose modes decay at rates that are decades apart, most within a step of the grid; noise wakes them at each step."""
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.standard_normal((4, 4)))
    A = turn @ np.diag([-1.0, -30.0, -400.0, -3000.0]) @ turn.T
    B, gain = turn @ [[1.0], [30], [400], [3000]], np.array([[0.05, 1.0, -4.0, 3.0]]) @ turn.T
    return Scenario(Plant(A, B, np.eye(4)), gain, state_feedback=True, x0=rng.standard_normal(4), W=np.eye(4), horizon=1.2, dt=0.04,
                    seed=seed, u_min=-0.1, u_max=0.1)


@pytest.mark.slow
def test_what_a_stiff_loop_does_within_a_step_is_seen() -> None:
    """Each step from the run's own state, by a solver that resolves the fastest mode."""
    def law(seed: int) -> None:
        s = stiff(seed)
        run, jumps = simulate(s), disturbances_of(s).jumps
        states, n = np.hstack([run.x, run.xhat]), s.plant.n
        assert jumps is not None
        for before, after, jump in zip(run.x, run.x[1:], jumps, strict=False):
            def slope(t: float, x: np.ndarray) -> np.ndarray:
                return s.plant.A @ x + s.plant.B @ np.clip(-s.K @ x, s.u_min, s.u_max)
            peer = solve_ivp(slope, (0, s.dt), before, "LSODA", rtol=1e-10, atol=1e-13, max_step=s.dt / 60).y[:, -1]
            assert np.abs(after - jump[:n] - peer).max() < 1e-8 * np.abs(states).max()
    holds_for_all(range(3), law)


def test_a_state_of_which_rounding_hides_the_input_ends_the_run_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """It had kept a lesson busy for minutes: u swayed by more than both limits with the last digit of the state."""
    pieces, stretch = [], Switcher._stretch
    monkeypatch.setattr(Switcher, "_stretch", lambda *given: pieces.append(1) or stretch(*given))
    one = np.array([1.0])
    far = Switcher(LOOP, -one, one, 0.01).advance(np.array([3e14, -1e15, 3e14, 2e14]), np.zeros(1), np.zeros(1), 0.01)
    assert not np.isfinite(far).all() and not pieces
    FAR = np.array([[3e14, -1e15, 3e14, 2e14], [1.0, 0.0, 0.0, 0.0]])
    both = part_step(Switcher(LOOP, -one, one, 0.01), FAR, np.zeros(1), np.zeros(1), np.full(2, 0.01))
    assert not np.isfinite(both[0]).all() and np.isfinite(both[1]).all()


def test_delay_with_a_limit_is_the_delayed_clipped_input() -> None:
    run = simulate(Scenario(DOUBLE, K, L, x0=[3.0, 0.0], delay=0.2, **ONE))
    assert np.array_equal(run.u_applied[20:], np.clip(run.u_asked, -1, 1)[:-20])
    assert run.saturated and np.abs(run.x[-1]).max() < 1e-2


@pytest.mark.parametrize("more", [
    {}, {"V": 1e-4 * np.eye(1), "W": 0.1 * np.eye(1)}, {"impulses": ((0.503, [0.2, 0.0]), (1.0, [0.0, -0.1]))},
    {"delay": 0.05}, {"sampled": True}, {"u_min": None, "u_max": None}], ids="-".join)
def test_a_run_that_is_looked_at_on_the_way_is_the_run_up_to_there(more: dict[str, Any]) -> None:
    s = Scenario(Plant([[0, 1], [1, 0]], [[0], [1]], [[1, 0]]), [[5.0, 4.0]], [[12.0], [37.0]], x0=[0.4, 0.0], horizon=2.0, dt=0.01,
                 **{"u_min": -1.0, "u_max": 1.0, **more})
    one = simulate(s)
    far = 0.95 * float(np.abs(one.x).max())
    past = int(np.argmax(np.abs(one.x).max(axis=1) > far))
    for looks in ([0.5, 1.0], [1.0, 5.0], []):
        never = simulate_until(s, looks, lambda x: False)
        found = simulate_until(s, looks, lambda x: bool(np.abs(x).max() > far))
        assert np.allclose(never.x, one.x, atol=1e-9) and np.allclose(never.u_applied, one.u_applied, atol=1e-7)
        ends = [end for end in (*(round(look / s.dt) for look in looks), s.n_t - 1) if past <= end < s.n_t]
        assert len(found.t) == ends[0] + 1 and np.allclose(found.xhat, one.xhat[:ends[0] + 1], atol=1e-9)
        assert (found.diverged_at is None) == (len(found.t) == s.n_t)
