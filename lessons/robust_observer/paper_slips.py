"""Check the slips of the printed paper: a transformed observer, product sizes, columns of M′.

All on example 2 with poles −4 and −3, in the paper's sign u = +K x and its letters: m outputs, p observer states.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

import numpy as np

from observer_lab.engine import functional_observer
from observer_lab.engine.observers import FunctionalObserver
from observer_lab.plants.duan import EXAMPLE_2

from .knobs import REMARKS, SENSITIVITY_LINES

LAMBDA = np.array([[2.0, 1.0], [0.5, -1.0]])  # Λ
PRINTED_SIZES = MappingProxyType({"TA": (2, 3), "LC": (2, 2), "MC": (1, 3), "N": (1, 2)})


@dataclass(frozen=True)
class Gaps:
    """How far (2b) and (2c) are missed, relative; None where the matrices do not even fit together."""

    dynamics: float | None
    output: float | None

    @property
    def met(self) -> bool:
        return self.dynamics is not None and self.output is not None and max(self.dynamics, self.output) < 1e-9


@lru_cache(maxsize=1)
def printed_observer() -> FunctionalObserver:
    """Example 2 with poles −4, −3 and W = I, in the paper's sign."""
    return functional_observer(EXAMPLE_2.plant, EXAMPLE_2.K_printed, 2, poles=[-4, -3], wrong=EXAMPLE_2.wrong)


def _gap(a: np.ndarray, b: np.ndarray) -> float | None:
    return float(np.linalg.norm(a - b) / np.linalg.norm(a)) if a.shape == b.shape else None


@lru_cache(maxsize=len(REMARKS))
def remark_3(choice: str) -> Gaps:
    """(2b) T A − F T = L C and (2c) K = N T + M C for the five matrices that a version of remark 3 gives."""
    o, back = printed_observer(), np.linalg.inv(LAMBDA)
    moved_F, T, L, N = LAMBDA @ o.F @ back, LAMBDA @ o.T, LAMBDA @ o.L, o.N @ back
    if choice == "printed":
        F, T, N = o.F, LAMBDA @ o.F, None  # Λ N Λ⁻¹ is (2×2)(1×2)(2×2): no product
    elif choice == "left":
        F = o.F
    else:
        F, N = moved_F, o.N @ LAMBDA if choice == "forward" else N
    A, C = o.plant.A, o.plant.C
    fits = T.shape[1] == A.shape[0]
    return Gaps(_gap(L @ C, T @ A - F @ T) if fits else None,
                _gap(o.K, N @ T + o.M @ C) if fits and N is not None else None)


@lru_cache(maxsize=len(SENSITIVITY_LINES))
def true_size(line: str) -> tuple[int, int]:
    """The size that the product really has."""
    o = printed_observer()
    product = {"TA": o.T @ EXAMPLE_2.dA, "LC": o.L @ EXAMPLE_2.dC, "MC": o.M @ EXAMPLE_2.dC, "N": o.N}[line]
    return product.shape[0], product.shape[1]


def free_columns() -> int:
    """Columns of M′: the dependences between the rows of T and of C, m + p − rank [T; C]."""
    o = printed_observer()
    rows = np.vstack([o.T, o.plant.C])
    return int(len(rows) - np.linalg.matrix_rank(rows))


def claimed_columns(choice: str) -> int:
    """What a formula for the columns of M′ gives here."""
    o = printed_observer()
    n, m, p, rank = o.plant.n, o.plant.p, o.order, int(np.linalg.matrix_rank(np.vstack([o.T, o.plant.C])))
    return {"np": n + p, "nm": n + m, "mp": m + p}[choice] - rank
