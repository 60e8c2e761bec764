"""Laws of the fit of a record to plants that are known: the poles lie within what is said, and so does the NIS.

    python tests/engine/record_laws.py [seeds]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import cont2discrete

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2])]

from observer_lab.engine.identification import Record, identify

DEVIATIONS = 3.0  # within which the poles must lie


@dataclass(frozen=True)
class Known:
    """A plant ẋ = A x + B (u + w), y = C x + v, sampled every dt s; the standard deviations q of w and r of v for a sample."""

    name: str
    A: tuple[tuple[float, ...], ...]
    B: tuple[tuple[float, ...], ...]
    C: tuple[tuple[float, ...], ...]
    dt: float
    rows: int
    q: float
    r: float

    def sampled(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A, B, C at the samples, by SciPy."""
        A, B, C = map(np.array, (self.A, self.B, self.C))
        found = cont2discrete((A, B, C, np.zeros((len(C), B.shape[1]))), self.dt)
        return found[0], found[1], found[2]

    def record(self, seed: int) -> Record:
        """A record from rest that has gone on for a while: random steps, five samples each."""
        A, B, C = self.sampled()
        rng = np.random.default_rng(seed)
        before, total = 200, self.rows + 200
        u = np.repeat(rng.choice([-1.0, 1.0], (total // 5 + 1, B.shape[1])), 5, axis=0)[:total]
        w, v = self.q * rng.standard_normal(u.shape), self.r * rng.standard_normal((total, len(C)))
        x, y = np.zeros(len(A)), np.zeros((total, len(C)))
        for k in range(total):
            y[k] = C @ x + v[k]
            x = A @ x + B @ (u[k] + w[k])
        return Record(self.dt * np.arange(self.rows), u[before:], y[before:])


PLANTS = (
    Known("spring and damper", ((0, 1), (-4, -0.8)), ((0,), (1,)), ((1, 0),), 0.1, 1200, 0.1, 0.05),
    Known("two tanks", ((-0.5, 0), (0.3, -2)), ((1,), (0,)), ((0, 1),), 0.2, 1600, 0.1, 0.05),
    Known("two masses", ((0, 0, 1, 0), (0, 0, 0, 1), (-20, 10, -0.6, 0.2), (10, -10, 0.2, -0.3)), ((0,), (0,), (1,), (0,)),
          ((0, 1, 0, 0),), 0.15, 2400, 0.1, 0.05),
    Known("two sensors", ((0, 1), (-4, -0.8)), ((0,), (1,)), ((1, 0), (0, 1)), 0.1, 1200, 0.2, 0.1),
)


@cache
def judged(plant: Known, seed: int) -> tuple[bool, bool, bool]:
    """Whether every pole lies within three of its standard deviations, the NIS in its band, and the order is found."""
    true = np.linalg.eigvals(plant.sampled()[0])
    found = identify(plant.record(seed), order=len(true))
    rows, columns = linear_sum_assignment(np.abs(true[:, None] - found.subspace.poles))
    away = np.abs(true[rows] - found.subspace.poles[columns])
    return (bool((away <= DEVIATIONS * found.subspace.deviations[columns]).all()), found.judged.nis_holds,
            found.subspace.suggested == len(true))


if __name__ == "__main__":
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    failed = False
    for plant in PLANTS:
        poles, nis, order = np.mean([judged(plant, seed) for seed in range(seeds)], axis=0)
        failed |= min(poles, nis) < 0.95
        print(f"{plant.name:18}  poles within {DEVIATIONS:g} deviations {poles:5.0%}  NIS in its band {nis:5.0%}  order found {order:5.0%}")
    sys.exit(failed)
