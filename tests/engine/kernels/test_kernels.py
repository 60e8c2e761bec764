"""Kernels give what the plain ways give, to rounding: as plain functions on small cases, compiled on all of them."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from observer_lab.engine import (
    Belief,
    EngineError,
    KalmanFilter,
    Plant,
    Scenario,
    SquareRootFilter,
    compensator,
    lqe,
    lqr,
    sampled_loop,
    simulate,
    simulate_trial,
)
from observer_lab.engine.filters import (
    Beliefs,
    Experiment,
    ExtendedKalmanFilter,
    LinearisedFilter,
    PrintedUnscentedFilter,
    Steering,
    UnscentedKalmanFilter,
    errors_squared,
    posterior_bound,
    simulate_filters,
    slopes_along,
)
from observer_lab.engine.kernels import COMPILE_CACHE, compile_cache, prepare_kernels
from observer_lab.engine.kernels.compile_cache import SIGNATURES
from observer_lab.engine.kernels.tape import recorded
from observer_lab.engine.network import Link, NetworkScenario, mean_bounds, simulate_network
from observer_lab.engine.sampled import Hardware, SampledLoop, loop_density, mechanics_response, sampled_controller, simulate_trials
from observer_lab.engine.simulation import Gear, Run, simulate_geared, simulate_recovery, simulate_starts
from observer_lab.engine.structure import best_mixing, dominance
from observer_lab.engine.systems import NonlinearPlant, affine_scan, held_scan
from observer_lab.lessons.decoupling.loops import three
from observer_lab.lessons.showdown.friction import Guides, rub
from observer_lab.plants import cart_pendulum
from observer_lab.plants.bodies import falling_body
from observer_lab.plants.platform import nonlinear

Parts = dict[str, np.ndarray]


def filtered(kind: type, n: int, p: int, steps: int, seed: int, lost: float) -> Parts:
    """A record through a random filter, some of its measurements lost."""
    rng = np.random.default_rng(seed)
    A, B, C = rng.standard_normal((n, n)), rng.standard_normal((n, 2)), rng.standard_normal((p, n))
    kf = kind(0.98 * A / max(abs(np.linalg.eigvals(A))), B, C, 0.1, 1.0)
    y = rng.standard_normal((steps, p))
    y[rng.random(y.shape) < lost] = np.nan
    track = kf.run(Belief(rng.standard_normal(n), 4 * np.eye(n)), y, rng.standard_normal((steps, 2)))
    return {name: getattr(track, name) for name in ("predicted", "means", "innovations", "covariances", "prior_covariances", "S", "gains")}


def loop(horizon: float, **more: object) -> Scenario:
    """A light spring between two limits, two inputs of which one is seldom clipped."""
    plant = Plant([[0, 1], [-30, -0.1]], [[0, 0.3], [1, 0.1]], [[1, 0]])
    K, L = lqr(plant.A, plant.B, 50 * np.eye(2), np.eye(2)).gain, lqe(plant.A, np.eye(2), plant.C, np.eye(2), 1e-3 * np.eye(1)).gain
    return Scenario(plant, K, L, horizon=horizon, dt=0.01, u_min=[-1, -0.5], u_max=[0.7, 1], **{"x0": [1.0, 0.0], **more})


def run(s: Scenario) -> Parts:
    found: Run = simulate(s)
    return {"x": found.x, "xhat": found.xhat, "u": found.u_applied}


def together(s: Scenario, runs: int, cut: int = 10**9) -> Parts:
    """Many starts, one of which the caller sets to zero on the way."""
    starts, states = np.random.default_rng(3).uniform(-2, 2, (runs, 4)), []
    for k, Z in enumerate(simulate_starts(s, starts)):
        if k == cut:
            Z[0] = 0.0
        states.append(Z.copy())
    return {"states": np.array(states)}


def mapped(s: Scenario, count: int, slices: float) -> Parts:
    *_, (_, found) = simulate_recovery(s, 0, np.linspace(-3, 3, count), 0, np.linspace(-2, 2, count), bound=6.0, slice_seconds=slices)
    return {"recovered": found.recovered.astype(float), "settling": np.nan_to_num(found.settling, posinf=-1.0)}


def sampled(steps: int, **hardware: float) -> SampledLoop:
    """A sampled controller on the spring, with the limits of its hardware."""
    s = loop(1.0)
    built = sampled_controller(compensator(s.plant, s.K, s.L), 0.01)
    return sampled_loop(Plant(s.plant.A, np.hstack([s.plant.B, np.eye(2)]), s.plant.C), built, [0, 1], hardware=Hardware(**hardware),
                        W=0.1 * np.eye(2), V=1e-6 * np.eye(1))


def trial(steps: int, **hardware: float) -> Parts:
    found = simulate_trial(sampled(steps, **hardware), steps, seed=1, kicks=((steps // 3, [1.0, 0.0]),))
    return {"w": found.w, "applied": found.applied}


def rubbing(steps: int, **hardware: float) -> Parts:
    """Three guides of which one rubs against both states' sum."""
    held, rng = sampled(steps, **hardware), np.random.default_rng(5)
    rows = np.zeros((3, held.n))
    rows[:, held.x] = [[1, 0], [0, 1], [1, 1]]
    w, f = rub(held, Guides(rows, 0.01 * rows.T), 2.0, np.eye(held.n)[held.x.start], 0.1 * rng.standard_normal((steps, held.n)),
               1e-3 * rng.standard_normal((steps, 1)))
    return {"w": w, "f": f}


def density(**hardware: float) -> Parts:
    held = sampled(10, **hardware)
    return {"density": loop_density(held, mechanics_response(held, [0.1, 1.0, 20.0]))}


def mixing(low: float, high: float) -> Parts:
    """The best mixing of the platform's last two channels over a band in Hz."""
    found = best_mixing(dominance(three(), 2 * np.pi * np.geomspace(low, high, 12)).response, channels=(1, 2))
    return {"ab": np.array([found.a, found.b]), "J": np.array([found.J])}


def lossy(steps: int) -> Parts:
    """A loop over packets, some of which are late, and bounds of the mean over three losses."""
    plant = Plant([[1.1, 0.2], [0.0, 0.9]], [[0], [1]], [[1, 0], [0, 1]], dt=1.0)
    eye, late = np.eye(2), Link(0.3, 0, 2)
    found = simulate_network(NetworkScenario(plant, [[0.5, 0.4]], eye, eye, eye, [1.0, 0.0], steps, late))
    lower, upper = mean_bounds(plant.A, plant.C[:1], eye, eye[:1, :1], eye, [0.1, 0.5, 0.6], 24)
    return {"x": found.x, "P": found.P, "lower": lower, "upper": upper}


def trials(steps: int, runs: int, **hardware: float) -> Parts:
    *_, (_, found) = simulate_trials(sampled(steps, **hardware), runs, steps / 100, 1, segment=8)
    return {"density": found.density, "rms": found.rms, "peak": found.peak, "clipped": found.clipped}


def geared(s: Scenario, **gear: object) -> Parts:
    found = simulate_geared(s, Gear(0, 1, 0.3, 0.7, [-10.0, 0.0], **gear))
    return {"x": found.run.x, "xhat": found.run.xhat, "v": found.run.v, "inner": found.inner, "contact": found.contact.astype(float)}


def watched(plant: NonlinearPlant, steps: int, size: float, points: type = UnscentedKalmanFilter, by: str = "", known: float = 0.0,
            parts: int = 1) -> Parts:
    """Runs watched by three filters, kicked on the way, the slopes along them, their bound and their squared errors."""
    n, m, runs, rng = plant.n, plant.m, 2, np.random.default_rng(4)
    flow, R = plant.flow(0.05, parts=parts), 1e-4 * size**2 * np.eye(plant.p)
    middle, P = np.zeros(n) if m else np.array(falling_body.GUESS), (size * np.linspace(1, known, n))**2
    Q = 1e-3 * np.diag(np.where(P > 0, P, size**2))
    made = {"points": points(flow, plant.output, Q, R, 0.7, 1.5, 1.0),
            "once": LinearisedFilter(flow, plant.output, Q, R, middle, np.zeros(m)),
            "along": ExtendedKalmanFilter(flow, plant.output, Q, R, h_expand=plant.observe)}
    steering = Steering(by, rng.standard_normal((m, n)), np.full(m, 0.5)) if by else None
    x0, inputs = middle[:, None] + np.sqrt(P)[:, None] * rng.standard_normal((n, runs)), 0.1 * rng.standard_normal((steps, m))
    e = Experiment(flow, plant.output, Q, R, x0, Beliefs.alike(middle, np.diag(P), runs), inputs, made, steering,
                   ((1, size * np.sqrt(P)),), plant)
    samples = list(simulate_filters(e, rng))
    x, u = (np.array([np.broadcast_to(getattr(s, what), (rows, runs)) for s in samples]) for what, rows in (("x", n), ("u", m)))
    found = {"x": x, "u": u, "y": np.array([s.y for s in samples])}
    for name in made:
        each = [s.corrections[name] for s in samples]
        found |= {f"{name} {part}": np.array([np.broadcast_to(getattr(c, part), (runs, *getattr(c, part).shape[1:])) for c in each])
                  for part in ("S", "gain")}
        found |= {f"{name} mean": np.array([c.beliefs.mean for c in each]), f"{name} nu": np.array([c.innovation for c in each]),
                  f"{name} P": np.array([np.broadcast_to(c.beliefs.covariance, (runs, n, n)) for c in each]),
                  f"{name} lost": np.array([s.lost[name] for s in samples], dtype=float)}
        found[f"{name} squares"] = errors_squared((x - found[f"{name} mean"]).swapaxes(1, 2), found[f"{name} P"])
    F, H = slopes_along(plant, 0.05, *(a.swapaxes(0, 1).reshape(a.shape[1], steps * runs) for a in (x, u)), parts=parts)
    F, H = F.reshape(steps, runs, n, n), H.reshape(steps, runs, -1, n)
    return found | {"F": F, "H": H, "bound": posterior_bound(F[:-1], H, Q, R, np.diag(P))}


def scanned(n: int, steps: int) -> Parts:
    """Affine recursions, forced in every state and by two inputs."""
    rng = np.random.default_rng(n)
    Phi, Gamma, inputs = rng.standard_normal((n, n)) / np.sqrt(n), rng.standard_normal((n, 2)), rng.standard_normal((steps, 2))
    Phi = Phi * (0.99 / np.abs(np.linalg.eigvals(Phi)).max())
    return {"held": held_scan(Phi, Gamma, inputs, Gamma[:, 0]), "forced": affine_scan(Phi, inputs @ Gamma.T, Gamma[:, 0], steps)}


NOISE = {"W": 0.1 * np.eye(2), "V": 1e-3 * np.eye(1), "G": np.eye(2)}
KICKED = {"impulses": ((0.055, [0.5, 0.3]), (0.07, [0.1, 0.0]), (0.2, [-1.0, 0.0]))}
FALLING = Plant([[0, 1], [1, 0]], [[0], [1]], [[1, 0]])


def cases(steps: int) -> Iterator[tuple[str, Callable[[], Parts]]]:
    """Work of about `steps` steps, by name."""
    for kind in (KalmanFilter, SquareRootFilter):
        for seed, (n, p, lost) in enumerate(((1, 1, 0.0), (3, 2, 0.3), (6, 4, 0.0), (4, 1, 0.5))):
            yield f"{kind.__name__} {n} {p} {lost}", partial(filtered, kind, n, p, steps, seed, lost)
    horizon = steps / 100
    reference = {"reference": np.outer(np.sin(np.arange(steps + 1) / 9), [1.0, 0.3])}
    for more in ({}, {"fed": "commanded"}, NOISE, KICKED, {**NOISE, **KICKED}, reference, {"delay": 0.03}):
        yield f"run {[*more]}", partial(run, loop(horizon, **more))
    for more in ({}, NOISE, KICKED, {**NOISE, **KICKED, **reference}, {"u_min": None, "u_max": None}):
        yield f"late {[*more]}", partial(run, replace(loop(horizon, fed="commanded", delay=0.03), **more))
    for more in ({}, NOISE, KICKED):
        yield f"together {[*more]}", partial(together, loop(horizon / 4, **more), 4, steps // 8)
    for hardware in ({"limit": 0.3}, {"step": 1e-3}, {"limit": 0.3, "step": 1e-3, "delay": 0.013}, {"limit": 1e-3, "walk": 0.1}):
        yield f"trial {hardware}", partial(trial, steps, **hardware)
        yield f"trials {hardware}", partial(trials, steps, 3, **hardware)
        yield f"density {hardware}", partial(density, **hardware)
        yield f"rubbing {hardware}", partial(rubbing, steps, **hardware)
    for band in ((0.1, 0.7), (0.1, 10.0), (1.0, 1.4)):
        yield f"mixing {band}", partial(mixing, *band)
    yield "lossy", partial(lossy, steps)
    yield from ((f"scan {n}", partial(scanned, n, 2 * steps)) for n in (1, 6, 31))
    once = Plant([[0, 1], [-30, -0.1]], [[0], [1]], [[1, 0]])
    arm = Scenario(once, [[40.0, 9.0]], [[30.0], [200.0]], x0=[0.3, 0.0], horizon=horizon, dt=0.01, reference=[2.0])
    for clip, gear in (({}, {"gap": 0.05}), (KICKED, {"gap": 0.02, "step": 1e-3, "sensor": "outer"}),
                       ({"u_min": -3, "u_max": 2}, {"gap": 0.05, "step": 1e-3}), ({}, {})):
        yield f"geared {[*clip]} {gear}", partial(geared, replace(arm, **clip), **gear)
    few = min(steps // 8, 25)
    yield "watched pole", partial(watched, cart_pendulum.nonlinear_plant(sensor="both"), few, 0.1, by="points")
    yield "watched pole, as printed", partial(watched, cart_pendulum.nonlinear_plant(), few, 0.1, PrintedUnscentedFilter, "once", 1.0)
    yield "watched fall", partial(watched, falling_body.plant(), few, 1.0, known=1e-6, parts=2)
    yield "watched deck", partial(watched, nonlinear.plant(), few, 1e-3, PrintedUnscentedFilter, "along", 1.0)
    falling = Scenario(FALLING, [[5.0, 4.0]], [[12.0], [37.0]], horizon=horizon / 8, u_min=-1, u_max=1, **KICKED)
    yield "map", partial(mapped, falling, 5, 10.0)
    yield "map in slices", partial(mapped, falling, 3, 0.0)
    stiff = Scenario(FALLING, [[5.0, 4.0]], [[400.0], [4e4]], x0=[1, 0], horizon=horizon / 8, u_min=-1, u_max=1)
    yield "stiff", partial(run, stiff)
    fleeing = Scenario(FALLING, [[5.0, 4.0]], [[12.0], [37.0]], x0=[1.2, 0], horizon=30.0, dt=0.25, u_min=-1, u_max=1)
    yield "fleeing", partial(run, fleeing)
    yield "late and fleeing", partial(run, replace(fleeing, u_min=None, u_max=None, dt=0.05, delay=1.0))


def differing(steps: int, kernels: dict) -> list[str]:
    """The cases in which these kernels and the plain ways differ by more than rounding."""
    found = []
    for name, work in cases(steps):
        with COMPILE_CACHE.holding(kernels):
            quick = work()
        with COMPILE_CACHE.holding({}):
            plain = work()
        for part, wanted in plain.items():
            got = quick[part]
            if got.shape != wanted.shape or not np.allclose(got, wanted, rtol=1e-9, atol=1e-10 * np.nanmax(np.abs(wanted), initial=1e-300),
                                                            equal_nan=True):
                found.append(f"{name}: {part}")
    return found


@pytest.mark.slow
def test_kernels_are_plain_functions_that_say_what_the_plain_ways_say() -> None:
    assert not differing(24, {f: f for f in SIGNATURES})


def test_what_a_kernel_cannot_judge_is_left_to_the_plain_way() -> None:
    twice = KalmanFilter([[1]], [[0]], [[1], [1]], 1.0, np.zeros((2, 2)))
    with COMPILE_CACHE.holding({f: f for f in SIGNATURES}), pytest.raises(EngineError, match="singular"):
        twice.run(Belief([0], [[0]]), np.ones((3, 2)))


def test_a_compiler_that_fails_leaves_the_plain_ways(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    def fails() -> dict:
        raise ImportError("another version is needed")

    monkeypatch.delenv("OBSERVER_LAB_KERNELS")
    monkeypatch.setattr(compile_cache, "cache_folder", lambda: None)
    monkeypatch.setattr(compile_cache, "_compiled", fails)
    prepare_kernels().join()
    assert not COMPILE_CACHE.made and "another version is needed" in caplog.text


def test_equations_that_no_tape_can_hold_are_left_to_numpy() -> None:
    for f in (np.abs, lambda x, u: np.where(x > 0, x, 0.0), lambda x, u: x if x[0] == 0 else -x, lambda x, u: np.maximum(x, 0.0),
              lambda x, u: np.arctan(x), lambda x, u: x.astype(float)):
        assert recorded(f, 1, 0, 1) is None
    assert recorded(lambda x, u: np.zeros_like(x), 2, 0, 2) is not None


@pytest.mark.slow
def test_compiled_kernels_say_what_the_plain_ways_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(COMPILE_CACHE, "made", {})
    prepare_kernels().join()
    assert not COMPILE_CACHE.made  # switched off for all tests
    monkeypatch.delenv("OBSERVER_LAB_KERNELS")
    prepare_kernels().join()
    assert set(COMPILE_CACHE.made) == set(SIGNATURES)
    assert not differing(800, COMPILE_CACHE.made)


def test_a_cache_is_only_called_complete_for_the_files_that_the_compiler_would_take_from_it(tmp_path, monkeypatch) -> None:
    """It asks for the place and the time of each file, not only for what stands in it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    here = compile_cache.cache_folder()
    assert here is not None and here == compile_cache.cache_folder()
    copy = tmp_path / "copy"
    shutil.copytree(Path(compile_cache.__file__).parent, copy)
    monkeypatch.setattr(compile_cache, "__file__", str(copy / "shelf.py"))
    moved = compile_cache.cache_folder()
    os.utime(copy / "small_matrices.py", (1, 1))
    touched = compile_cache.cache_folder()
    monkeypatch.setattr(compile_cache, "version", lambda name: "another")
    assert len({here, moved, touched, compile_cache.cache_folder()}) == 4
