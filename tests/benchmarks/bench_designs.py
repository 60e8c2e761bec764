"""Gains and responses beside python-control and SciPy: lqr and lqe, placement, a response, spectra of the platform, margins."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import control
import numpy as np
from scipy.signal import place_poles
from stopwatch import Row, median

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "engine"))

from fifty_digits import response as exact_response
from fifty_digits import riccati_residual

from observer_lab.engine import Plant, compensator, frequency_response, loop_margins, lqe, lqr, noisy_loop, place
from observer_lab.plants.platform import lqg_weights, model
from observer_lab.plants.platform.channels import T_y

UNIT = 1e-12  # python-control's lqe fails at the platform's scales; divided by this it works
YT = {"method": "YT", "rtol": 1e-9, "maxiter": 30}


def random_case(seed: int, n: int = 10, m: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A, B and real poles."""
    rng = np.random.default_rng(seed)
    poles = -rng.uniform(1, 8, n)
    return rng.standard_normal((n, n)), rng.standard_normal((n, m)), poles


def riccati() -> Iterator[Row]:
    """lqr and lqe of ten random states, and both of the platform; what is said is the residual of S in fifty digits."""
    A, B, _ = random_case(1)
    Q, R = np.eye(10), np.eye(3)
    said = _residuals((A, B, Q, R), lqr(A, B, Q, R).solution, control.lqr(A, B, Q, R, method="scipy")[1])
    yield Row("lqr, n = 10", median(lambda: lqr(A, B, Q, R)), "control.lqr", median(lambda: control.lqr(A, B, Q, R, method="scipy")), 1,
              said=said)
    said = _residuals((A.T, B, B @ B.T, R), lqe(A, B, B.T, R, R).solution, control.lqe(A, B, B.T, R, R, method="scipy")[1])
    yield Row("lqe, n = 10", median(lambda: lqe(A, B, B.T, R, R)), "control.lqe",
              median(lambda: control.lqe(A, B, B.T, R, R, method="scipy")), 1, said=said)
    whole = model.plant()
    coils, G, W = lqg_weights.coils(whole), lqg_weights.ground(whole), lqg_weights.Weights()
    Q, R = W.Q(whole), W.R

    def theirs() -> np.ndarray:
        return np.asarray(control.lqr(coils.A, coils.B, Q, R, method="scipy")[1]), np.asarray(
            control.lqe(coils.A, G, coils.C, W.W / UNIT, W.V / UNIT, method="scipy")[1])

    ours = median(lambda: (lqr(coils.A, coils.B, Q, R), lqe(coils.A, G, coils.C, W.W, W.V)))
    said = _residuals((coils.A, coils.B, Q, R), lqr(coils.A, coils.B, Q, R).solution, theirs()[0])
    yield Row("lqr and lqe of the platform", ours, "python-control, noise scaled by hand", median(theirs), 1, said=said)


def _residuals(problem: tuple[np.ndarray, ...], ours: np.ndarray, theirs: np.ndarray) -> str:
    A, B, Q, R = problem
    ratio = [float(riccati_residual(A, B, Q, R, np.asarray(S))) for S in (ours, theirs)]
    return f"residual {ratio[0]:.1e}, peer {ratio[1]:.1e}"


def placement() -> Row:
    """Twelve random plants; the ratio of the conditions of the eigenvectors, ours to the peer's."""
    ours, theirs, ratios = [], [], []
    for seed in range(12):
        A, B, poles = random_case(seed)
        ours.append(median(lambda A=A, B=B, poles=poles: place(A, B, poles), 0))
        theirs.append(median(lambda A=A, B=B, poles=poles: place_poles(A, B, poles, **YT), 0, 1))
        gains = place(A, B, poles).gain, place_poles(A, B, poles, **YT).gain_matrix
        one, other = (np.linalg.cond(np.linalg.eig(A - B @ K)[1]) for K in gains)
        ratios.append(one / other)
    said = f"κ ours/peer {np.median(ratios):.2f}, at worst {max(ratios):.2f}"
    return Row("placement, n = 10, m = 3", float(np.median(ours)), "scipy YT to its limit", float(np.median(theirs)), 20, said=said)


def responses() -> Iterator[Row]:
    """1000 frequencies of the rig's plant, and three densities of the platform's LQG loop."""
    from bench_loops import rig

    plant, omega = rig()[0], np.logspace(-1, 3, 1000)
    system = control.ss(plant.A, plant.B, plant.C, plant.D)
    few = omega[::100]
    true = exact_response(plant, few)
    off = [float(np.max(np.abs(np.asarray(H) / true - 1))) for H in (
        frequency_response(plant.A, plant.B, plant.C, plant.D, few), np.moveaxis(system(1j * few), 2, 0))]
    yield Row("response at 1000 frequencies, 4×3", median(lambda: frequency_response(plant.A, plant.B, plant.C, plant.D, omega)),
              "python-control", median(lambda: system(1j * omega)), 20, said=f"off {off[0]:.1e}, peer {off[1]:.1e} relative")
    whole = model.plant()
    coils, G, W, f = lqg_weights.coils(whole), lqg_weights.ground(whole), lqg_weights.Weights(), np.geomspace(0.01, 100, 200)
    design = lqg_weights.lqg(whole)
    loop = noisy_loop(coils, design.controller, G, W.W, V=W.V)
    rows, sources = loop.outputs(T_y[:3]), 2 * np.diag(loop.noise)

    def ours() -> np.ndarray:
        fresh = noisy_loop(coils, design.controller, G, W.W, V=W.V)
        return fresh.psd(f, fresh.outputs(T_y[:3]))

    def theirs() -> np.ndarray:
        H = control.ss(loop.A, loop.B, rows @ loop.C, rows @ loop.D)(2j * np.pi * f)
        return (np.abs(H) ** 2 * sources[None, :, None]).sum(axis=1).T

    yield Row("3 densities of the platform's loop, 200 frequencies", median(ours), "python-control", median(theirs), 5,
              said=f"differ by {np.abs(theirs() / ours() - 1).max():.1e} relative")


def margins() -> Row:
    """Gain, phase and disk margin of one loop of the platform."""
    whole = model.plant()
    one = Plant(whole.A, whole.B[:, :1], whole.C[:1])
    built = compensator(one, lqr(one.A, one.B, 1e10 * one.C.T @ one.C, 0.1).gain, lqe(one.A, one.B, one.C, 1e-6, 1e-9).gain)
    loop = -control.ss(built.A, built.B, built.C, 0) * control.ss(one.A, one.B, one.C, 0)
    omega = loop_margins(one, built).loop.omega[1:-1]

    def theirs() -> None:
        control.disk_margins(loop, omega)
        control.stability_margins(loop)

    return Row("margins of one loop of the platform", median(lambda: loop_margins(one, built).inputs), "disk_margins + stability_margins",
               median(theirs))


def rows() -> Iterator[Row]:
    """All rows about designs."""
    yield from riccati()
    yield placement()
    yield from responses()
    yield margins()
