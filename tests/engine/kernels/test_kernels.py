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
from observer_lab.engine.kernels import COMPILE_CACHE, compile_cache, prepare_kernels
from observer_lab.engine.kernels.compile_cache import SIGNATURES
from observer_lab.engine.sampled import Hardware, SampledLoop, sampled_controller, simulate_trials
from observer_lab.engine.simulation import Gear, Run, simulate_geared, simulate_recovery, simulate_starts
from observer_lab.lessons.showdown.friction import Guides, rub

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


def trials(steps: int, runs: int, **hardware: float) -> Parts:
    *_, (_, found) = simulate_trials(sampled(steps, **hardware), runs, steps / 100, 1, segment=8)
    return {"density": found.density, "rms": found.rms, "peak": found.peak, "clipped": found.clipped}


def geared(s: Scenario, **gear: object) -> Parts:
    found = simulate_geared(s, Gear(0, 1, 0.3, 0.7, [-10.0, 0.0], **gear))
    return {"x": found.run.x, "xhat": found.run.xhat, "v": found.run.v, "inner": found.inner, "contact": found.contact.astype(float)}


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
    for more in ({}, NOISE, KICKED):
        yield f"together {[*more]}", partial(together, loop(horizon / 4, **more), 4, steps // 8)
    for hardware in ({"limit": 0.3}, {"step": 1e-3}, {"limit": 0.3, "step": 1e-3, "delay": 0.013}, {"limit": 1e-3, "walk": 0.1}):
        yield f"trial {hardware}", partial(trial, steps, **hardware)
        yield f"trials {hardware}", partial(trials, steps, 3, **hardware)
        yield f"rubbing {hardware}", partial(rubbing, steps, **hardware)
    once = Plant([[0, 1], [-30, -0.1]], [[0], [1]], [[1, 0]])
    arm = Scenario(once, [[40.0, 9.0]], [[30.0], [200.0]], x0=[0.3, 0.0], horizon=horizon, dt=0.01, reference=[2.0])
    for clip, gear in (({}, {"gap": 0.05}), (KICKED, {"gap": 0.02, "step": 1e-3, "sensor": "outer"}),
                       ({"u_min": -3, "u_max": 2}, {"gap": 0.05, "step": 1e-3}), ({}, {})):
        yield f"geared {[*clip]} {gear}", partial(geared, replace(arm, **clip), **gear)
    falling = Scenario(FALLING, [[5.0, 4.0]], [[12.0], [37.0]], horizon=horizon / 8, u_min=-1, u_max=1, **KICKED)
    yield "map", partial(mapped, falling, 5, 10.0)
    yield "map in slices", partial(mapped, falling, 3, 0.0)
    stiff = Scenario(FALLING, [[5.0, 4.0]], [[400.0], [4e4]], x0=[1, 0], horizon=horizon / 8, u_min=-1, u_max=1)
    yield "stiff", partial(run, stiff)
    fleeing = Scenario(FALLING, [[5.0, 4.0]], [[12.0], [37.0]], x0=[1.2, 0], horizon=30.0, dt=0.25, u_min=-1, u_max=1)
    yield "fleeing", partial(run, fleeing)
    if steps > 100:  # what overflows warns in a plain function
        yield "gone at once", partial(run, Scenario(Plant([[1e5]], [[1]], [[1]]), x0=[1.0], horizon=1.0, reference=np.ones(1), u_max=1.0))


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


@pytest.mark.slow
def test_compiled_kernels_say_what_the_plain_ways_say(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(COMPILE_CACHE, "made", {})
    prepare_kernels().join()
    assert not COMPILE_CACHE.made  # switched off for all tests
    monkeypatch.delenv("OBSERVER_LAB_KERNELS")
    prepare_kernels().join()
    assert set(COMPILE_CACHE.made) == set(SIGNATURES)
    assert not differing(800, COMPILE_CACHE.made)


@pytest.mark.slow
def test_a_copy_of_the_lab_takes_compiled_kernels_from_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compile_cache._compiled()
    for kernel in SIGNATURES:
        moved = shutil.copy(kernel.__code__.co_filename, tmp_path)
        monkeypatch.setattr(kernel, "__code__", kernel.__code__.replace(co_filename=moved))
    assert all(made.stats.cache_hits and not made.stats.cache_misses for made in compile_cache._compiled().values())


def test_the_cache_goes_by_the_contents_of_the_kernels_and_by_the_compiler(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    here = compile_cache.cache_folder()
    copy = tmp_path / "copy"
    shutil.copytree(Path(compile_cache.__file__).parent, copy)
    os.utime(copy / "small_matrices.py", (1, 1))
    monkeypatch.setattr(compile_cache, "__file__", str(copy / "compile_cache.py"))
    assert here is not None and here == compile_cache.cache_folder()
    with (copy / "small_matrices.py").open("a") as file:
        file.write("# changed\n")
    changed = compile_cache.cache_folder()
    monkeypatch.setattr(compile_cache, "version", lambda name: "another")
    assert len({here, changed, compile_cache.cache_folder()}) == 3
