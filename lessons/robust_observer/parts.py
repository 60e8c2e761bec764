"""Split the error of û into what the start leaves and what each model error adds.

With ζ = z − T x the loop gives ζ̇ = F ζ + (L ΔC − T ΔA) x − T ΔB u and û − u = −N ζ − M ΔC x. Both are linear in ΔA, ΔB and ΔC, so
the error is a sum with one part for the start and one for each of them. The real run drives each part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from observer_lab.engine.observers import FunctionalObserver
from observer_lab.engine.systems import affine_scan

from .loop import Run


@dataclass(frozen=True, eq=False)
class Cause:
    """One error of the model: δ times a direction of A, B or C, zero where it is not given."""

    A: np.ndarray | float = 0.0
    B: np.ndarray | float = 0.0
    C: np.ndarray | float = 0.0


def error_parts(run: Run, o: FunctionalObserver, causes: Sequence[Cause]) -> np.ndarray:
    """û − u in parts (n_t, 1 + causes), the start first: exact at the samples, as the run is."""
    n, q, loop, plant = o.plant.n, o.order, run.loop, o.plant
    size, rate = n + q, loop.drive.rate
    turned = rate * run.t + loop.drive.phase
    real = np.column_stack([run.x, run.z, np.sin(turned), np.cos(turned)])
    whole = np.zeros((size + 2, size + 2))
    whole[:size, :size], whole[:size, size] = loop.A, loop.drive.amplitude * loop.b
    whole[size, size + 1], whole[size + 1, size] = rate, -rate
    inputs = np.column_stack([loop.inputs, loop.drive.amplitude * (np.arange(plant.m) == loop.drive.on), np.zeros(plant.m)])
    states, zero_A, zero_C = np.eye(n, size + 2), np.zeros((n, n)), np.zeros_like(plant.C)  # x of the real run
    drives = [np.zeros((q, size + 2)), *((o.L @ (zero_C + each.C) - o.T @ (zero_A + each.A)) @ states
                                         - o.T @ (np.zeros_like(plant.B) + each.B) @ inputs for each in causes)]
    direct = [np.zeros(n), *((o.M @ (zero_C + each.C))[0] for each in causes)]
    start = np.concatenate([run.z[0] - o.T @ run.x[0], np.zeros(q * len(causes))])
    chain = np.block([[whole, np.zeros((size + 2, len(start)))], [np.vstack(drives), np.kron(np.eye(len(drives)), o.F)]])
    with np.errstate(over="ignore", invalid="ignore"):
        step: np.ndarray = expm(chain * (run.t[1] - run.t[0]))[size + 2:]
        zeta = affine_scan(step[:, size + 2:], real[:-1] @ step[:, :size + 2].T, start, len(run.t) - 1)
    return np.column_stack([-zeta[:, q * k:q * (k + 1)] @ o.N[0] - run.x @ at_once for k, at_once in enumerate(direct)])
