"""A gear with play: one body without a gap, momentum kept at an impact, never past a flank, and the play operator where all is slow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laws import each
from scipy.integrate import solve_ivp

from observer_lab.engine import EngineError, Plant, Scenario, simulate
from observer_lab.engine.simulation import Gear, simulate_geared

J1, J2, DRAG = 0.3, 1.2, 0.4
BODY = Plant([[0, 1], [0, -DRAG / (J1 + J2)]], [[0], [1 / (J1 + J2)]], [[1, 0]])
GEAR = Gear(0, 1, J1, J2, [0.0, -DRAG], gap=0.2)
LOOP = Scenario(BODY, K=[[3.0, 2.0]], L=[[8.0], [20.0]], horizon=6.0, dt=0.002, reference=[3.0], impulses=((3.0, [0.0, -0.8]),))


def play(inner: np.ndarray, half: float) -> np.ndarray:
    """The play operator: w[k] = max(v[k] − r, min(v[k] + r, w[k − 1])), from the middle."""
    outer, now = np.empty(len(inner)), float(inner[0])
    for k, value in enumerate(inner):
        outer[k] = now = max(value - half, min(value + half, now))
    return outer


@each("limit", [np.inf, 1.0])
def test_without_a_gap_it_is_the_one_body_that_the_plant_describes(limit: float) -> None:
    s = replace(LOOP, u_max=limit, u_min=-limit)
    rigid, geared = simulate(s), simulate_geared(s, replace(GEAR, gap=0.0))
    assert np.allclose(geared.run.x, rigid.x, atol=1e-9 if limit > 1 else 1e-3) and np.allclose(geared.inner, rigid.x[:, 0], atol=1e-2)
    assert geared.run.saturated == rigid.saturated


def test_the_bodies_never_pass_a_flank_and_are_apart_by_half_the_gap_in_contact() -> None:
    found = simulate_geared(LOOP, GEAR)
    apart = found.inner - found.run.x[:, 0]
    assert float(np.max(np.abs(apart))) <= GEAR.gap / 2 + 1e-9 and set(found.contact) == {-1, 0, 1}
    touching = found.contact != 0
    assert np.allclose(apart[touching], found.contact[touching] * GEAR.gap / 2, atol=1e-9)


def test_an_impact_keeps_the_momentum_and_makes_no_energy() -> None:
    free = Plant([[0, 1], [0, 0]], [[0], [1.0]], [[1, 0]])
    s = Scenario(free, x0=[0.0, 0.0], horizon=1.0, dt=0.001, reference=np.repeat([[1.0], [0.0]], [300, 701], axis=0))
    found = simulate_geared(s, Gear(0, 1, J1, J2, [0.0, 0.0], gap=0.04))
    inner = np.gradient(found.inner, s.dt)
    outer, apart = found.run.x[:, 1], found.contact == 0
    after = np.flatnonzero(~apart)[0]
    assert J2 * outer[-1] + J1 * inner[-2] == pytest.approx((J1 + J2) * 0.3, rel=1e-3)  # the push of 0.3 s, in units of J₁ + J₂
    assert outer[after - 2] == 0.0 and 0 < outer[after] < inner[after - 2]


def test_between_flanks_and_in_contact_an_integrator_of_scipy_finds_the_same() -> None:
    """The same contact with stiff flanks instead of rigid ones, and much damping in them."""
    stiff, damping, half = 4e5, 4e3, GEAR.gap / 2

    def rates(t: float, z: np.ndarray) -> list[float]:
        q1, w1, q2, w2, *xhat = z
        apart = q1 - q2
        deep = apart - np.clip(apart, -half, half)
        torque = stiff * deep + damping * (w1 - w2) if deep else 0.0
        torque = max(torque, 0.0) if deep > 0 else min(torque, 0.0)
        u = 3.0 - 3.0 * xhat[0] - 2.0 * xhat[1]
        late = q1 - xhat[0]
        return [w1, (u * 1.0 - torque) / J1, w2, (torque - DRAG * w2) / J2, xhat[1] + 8.0 * late,
                (u - DRAG * xhat[1]) / (J1 + J2) + 20.0 * late]
    s = replace(LOOP, horizon=2.5, impulses=(), reference=[3.0])
    peer = solve_ivp(rates, (0.0, 2.5), np.zeros(6), method="LSODA", rtol=1e-8, atol=1e-10, max_step=0.01, t_eval=[0.5, 1.0, 1.5, 2.0, 2.5])
    found = simulate_geared(s, GEAR)
    at = [found.run.index(t) for t in peer.t]
    assert np.allclose(found.inner[at], peer.y[0], atol=4e-3) and np.allclose(found.run.x[at, 0], peer.y[2], atol=4e-3)


def hysteresis(seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """A slow swing, and a quarter of the next, of a light arm that friction holds: angles of motor and arm."""
    plant, dt = Plant([[0, 1], [0, -50.0]], [[0], [1.0]], [[1, 0]]), 0.01
    t = dt * np.arange(round(1.25 * seconds / dt) + 1)
    s = Scenario(plant, K=[[400.0, 0.0]], L=[[60.0], [900.0]], horizon=float(t[-1]), dt=dt,
                 reference=400 * np.sin(2 * np.pi * t / seconds)[:, None])
    found = simulate_geared(s, Gear(0, 1, 0.999, 0.001, [0.0, -25.0], gap=0.3))
    return found.inner, found.run.x[:, 0]


def test_an_arm_held_by_friction_obeys_the_play_operator_whatever_the_rate() -> None:
    for seconds in (6.0, 12.0):
        motor, arm = hysteresis(seconds)
        assert np.allclose(arm, play(motor, 0.15), atol=1e-4)
        falling, rising = np.flatnonzero(np.diff(np.sign(motor[10:])))[:2] + 10
        assert arm[falling] - arm[rising] == pytest.approx(0.3, abs=0.03)  # as wide as the gap


@each("step", [0.01, 0.1])
def test_an_encoder_reads_whole_steps(step: float) -> None:
    run = simulate_geared(LOOP, replace(GEAR, sensor="outer", step=step)).run
    assert np.allclose(run.y / step, np.rint(run.y / step), atol=1e-9) and np.all(np.abs(run.v) <= step / 2 + 1e-12)
    assert np.allclose(run.y[:, 0] - run.v[:, 0], run.x[:, 0], atol=1e-9)


def test_what_it_cannot_run_is_a_sentence() -> None:
    for wrong in (replace(LOOP, fed="commanded"), replace(LOOP, delay=0.02), replace(LOOP, V=[[1e-6]]), replace(LOOP, sampled=True)):
        with pytest.raises(EngineError, match="continuous"):
            simulate_geared(wrong, GEAR)
    with pytest.raises(EngineError, match="fit"):
        simulate_geared(LOOP, replace(GEAR, angle=5))
