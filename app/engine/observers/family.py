"""Parametrise all functional observers of one order, over which RLO searches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from ..structure.coprime import CoprimeFactors
from ..systems.balance import MIN_RATE
from ..systems.plant import Plant
from ..systems.pole_sets import Poles
from .directions import full_stack, gap, l_rows, linear_directions, row_condition, seen_rows, solve_row, t_rows, unpack
from .perturbation import Norm, Perturbations, criterion

__all__: list[str] = []

CONDITION_RTOL = 1e-9
PROBES = 6


class Family:
    """A point is (poles; rest): for each pair (Re, Im), then the real poles; what is left free follows.

    For one wanted row (r = 1) K = c [C; H(s₁)ᵀ; …] is linear in c, from which g, N and M are read: the rest pulls c
    where the rows depend on each other. For several rows the rest is (g; M′). `thin`: K fits for special poles or
    directions only, so a point must be bent first.
    """

    def __init__(self, plant: Plant, K: np.ndarray, factors: CoprimeFactors, wrong: Perturbations, norm: Norm,
                 order: int, pairs: int, worst_condition: float) -> None:
        self.plant, self.K, self.factors, self.wrong = plant, K, factors, wrong
        self.norm: Norm = norm
        self.order, self.pairs, self.worst = order, pairs, worst_condition
        self.heads, self.single = order - pairs, len(K) == 1
        self.seen = seen_rows(plant.A, plant.C)
        p = plant.p
        self.spare = order + p > plant.n or len(self.seen[0]) < p  # rows of [T; C] depend, so M' exists
        if self.single:
            self.rest = 0  # `look` finds out how much room there is
        else:
            self.rest = (order * p if p > 1 else 0) + (len(K) * p if self.spare else 0)
        self.thin, self.least_gap, self.evaluations, self.pull = False, np.inf, 0, np.zeros((0, 0))

    @property
    def size(self) -> int:
        """Numbers in a point."""
        return self.order + self.rest

    def poles(self, point: np.ndarray) -> Poles:
        """The heads: pairs first (Im > 0), then real poles."""
        k = 2 * self.pairs
        return np.concatenate([point[:k:2] + 1j * point[1:k:2], point[k:self.order].astype(complex)])

    def look(self, sample: Callable[[np.random.Generator], np.ndarray], rng: np.random.Generator) -> None:
        """Find out by a few points whether K fits everywhere, and whether c has room."""
        probes = [sample(rng) for _ in range(PROBES)]
        if self.single:
            stacks = [full_stack(self.factors, self.plant.C, self.poles(x)) for x in probes]
            units = [stack / np.maximum(np.linalg.norm(stack, axis=1), 1e-300)[:, None] for stack in stacks]
            self.rest = len(stacks[0]) - max(int(np.linalg.matrix_rank(unit, 1e-10)) for unit in units)
            self.pull = rng.standard_normal((len(stacks[0]), self.rest)) * np.linalg.norm(self.K)
            probes = [sample(rng) for _ in range(PROBES)]
        self.thin = min(np.linalg.norm(self.missed(x)) for x in probes) > CONDITION_RTOL

    def missed(self, point: np.ndarray) -> np.ndarray:
        """(K − N T − M C)/‖K‖ at its best, flat."""
        heads = self.poles(point)
        if self.single:
            stack = full_stack(self.factors, self.plant.C, heads)
            rest = (self.K[0] - solve_row(stack, self.K[0])[0] @ stack) / np.linalg.norm(self.K)
        else:
            missed = gap(self.factors, self.plant.C, self.K, heads, self._given(point, heads))
            rest = missed.ravel() / np.linalg.norm(self.K)
        self.least_gap = min(self.least_gap, float(np.linalg.norm(rest)))
        return rest

    def bend(self, point: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The point moved until K fits, poles kept in their box; where it cannot, the best there is."""
        free = self.order if self.single else self.size
        bottom, top = np.full(free, -np.inf), np.full(free, np.inf)
        slack = 1e-12 * (np.abs(low) + np.abs(high)) + MIN_RATE
        bottom[:low.size], top[:high.size] = low - slack, high + slack
        start = point[:free].copy()
        widths = np.concatenate([np.abs(low) + np.abs(high), np.ones(free - low.size)])
        if np.linalg.norm(self.missed(point)) < 1e-13:
            return point
        fit = least_squares(lambda v: self.missed(np.concatenate([v, point[free:]])), start, bounds=(bottom, top),
                            x_scale=np.maximum(np.abs(start), 1e-3 * widths + MIN_RATE), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=40)
        bent = np.concatenate([fit.x, point[free:]])
        bent[:low.size] = np.clip(bent[:low.size], low, high)
        return bent

    def _given(self, point: np.ndarray, heads: Poles) -> np.ndarray:
        if self.plant.p == 1:
            return np.ones((len(heads), 1), dtype=complex)
        return unpack(point[self.order:self.order + self.order * self.plant.p], heads, self.plant.p)

    def design(self, point: np.ndarray) -> tuple[Poles, np.ndarray, np.ndarray, np.ndarray]:
        """All poles (q,), directions (heads, p), N (r×q) and M (r×p) of a point."""
        heads = self.poles(point)
        whole = np.concatenate([[s] if s.imag == 0 else [s, s.conjugate()] for s in heads])
        return whole, *self._design(point, heads)

    def _design(self, point: np.ndarray, heads: Poles) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        C, K, p = self.plant.C, self.K, self.plant.p
        if self.single:
            stack = full_stack(self.factors, C, heads)
            shift = self.pull @ point[self.order:] if self.rest else None
            c, _ = solve_row(stack, K[0], shift)
            return linear_directions(stack, p, heads, c)
        g = self._given(point, heads)
        rows = np.vstack([t_rows(self.factors, heads, g), C])
        length = np.maximum(np.linalg.norm(rows, axis=1), 1e-300)
        rows, both = rows / length[:, None], np.zeros((len(K), len(rows)))
        if self.spare:
            both[:, self.order:] = point[-len(K) * p:].reshape(len(K), p) * np.linalg.norm(K)
        both = (both + np.linalg.lstsq(rows.T, (K - both @ rows).T, rcond=1e-12)[0].T) / length
        return g, both[:, :self.order], both[:, self.order:]

    def J(self, point: np.ndarray) -> float:
        """The criterion at a point, infinite where K does not fit or [T; C] is too badly conditioned."""
        self.evaluations += 1
        heads = self.poles(point)
        g, N, M = self._design(point, heads)
        T, C = t_rows(self.factors, heads, g), self.plant.C
        missed = float(np.linalg.norm(self.K - N @ T - M @ C) / np.linalg.norm(self.K))
        self.least_gap = min(self.least_gap, missed)
        if not missed <= CONDITION_RTOL:
            return np.inf
        if not row_condition(T, *self.seen) <= self.worst:
            return np.inf
        return criterion(T, l_rows(self.factors, heads, g), M, self.wrong, norm=self.norm)


