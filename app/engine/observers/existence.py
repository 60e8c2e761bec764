"""Decide whether a functional observer exists, by the ranks of [T; C] and [T; C; K]."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..structure.coprime import coprime_factors
from ..systems.balance import balance
from ..systems.gates.argument_checks import POLES, matrix, takes
from ..systems.gates.plant_gate import PLANT
from ..systems.plant import Plant
from ..systems.pole_sets import check_poles
from ..systems.records import record
from .directions import choose_directions, seen_rows, upper_half_poles
from .functional import check_functional, like_units, real_rows, unlike_units

__all__ = ["Existence", "existence"]

RANK_RTOL = 1e-9  # a direction counts from here on, in rows of unit length


@record(eq=True)
class Existence:
    """The conditions for one set of poles: `rows` q + p of [T; C], their `rank` r*, the rank `with_K`, the share of ‖K‖ `missed`."""

    order: int
    rows: int
    rank: int
    with_K: int
    missed: float

    @property
    def exists(self) -> bool:
        """Condition (11): the rows of K add nothing to the rank."""
        return self.with_K == self.rank

    @property
    def free(self) -> int:
        """Columns of the free M′ in (13): rows of [T; C] that depend on the others."""
        return self.rows - self.rank


@takes(plant=PLANT, K=matrix(), poles=POLES)
def existence(plant: Plant, K: object, poles: Any) -> Existence:
    """Whether K (r×n) = N T + M C can be solved with observer poles (q,), and with how much freedom; no poles: K = M C.

    rank [T; C] = rank [T; C; K] (11), M′ r×(q + p − rank [T; C]) (13). Rows of unit length in balanced states; directions of T
    are chosen so that K fits if it can. Raises EngineError, PoleError, ShapeError as `functional_observer` does for its arguments.
    Source: Duan, Li, Zhou (1993), (11)–(13), where M′ is misprinted to have n + q − r* columns.

    >>> existence(Plant([[0, 1], [-2, -3]], [[0], [1]], [[1, 0]]), [[1, 1]], [-5, -6]).free
    1
    """
    wanted = check_functional(plant, K)
    own = balance(plant.A, None, plant.C)
    rate = 1.0
    if unlike_units(plant, own):  # as `functional_observer` does
        plant, wanted, _, rate = like_units(plant, wanted, own)
    seen, d = seen_rows(plant.A, plant.C)
    asked, T = np.zeros(0, dtype=complex), np.zeros((0, plant.n))
    if np.size(poles):
        asked, factors = check_poles(poles, np.size(poles)) / rate, coprime_factors(plant)
        heads = upper_half_poles(asked)
        T = real_rows(plant, factors, heads, choose_directions(factors, plant, wanted, heads))[1]
    _, s, Vt = np.linalg.svd(np.vstack([_unit(T * d), seen]))
    rank = int(np.count_nonzero(s > RANK_RTOL * s[0]))
    row = _unit(wanted * d)
    more = np.linalg.svd(row - row @ Vt[:rank].T @ Vt[:rank], compute_uv=False)
    Q = np.linalg.qr((_unit(Vt[:rank] / d)).T)[0]
    return Existence(asked.size, asked.size + plant.p, rank, rank + int(np.count_nonzero(more > RANK_RTOL)),
                     float(np.linalg.norm(wanted - wanted @ Q @ Q.T) / np.linalg.norm(wanted)))


def _unit(rows: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return rows / np.where(length > 0, length, 1.0)
