"""Find repeated roots of a polynomial that rounding has separated."""

from __future__ import annotations

import numpy as np

from ..systems.pole_sets import Poles

__all__ = ["merge_repeated_roots"]

COEFFICIENT_ROUNDING = 4 * float(np.finfo(float).eps)  # for each degree: what building the coefficients may have cost them
LOOSE = (1e6, 1e3, 1.0)  # how much more is allowed until all roots are moved together
REFINED = 4  # steps of Gauss and Newton
SAME_ROOT_RTOL = 1e-9  # of a root: what parts a root from the conjugate of its partner is less


def merge_repeated_roots(polynomial: np.ndarray, roots: Poles) -> Poles:
    """The roots (n,) of a real polynomial (n + 1,), each complex one beside its exact conjugate, in no order.

    Neighbours become one root, together with their mirror images, where the product of the factors stays the
    polynomial to rounding, |Δp_k| ≤ 4 n eps |p_0| ∏(s + |root|)_k; of such groups the widest count. Source of moving the
    distinct roots together: Zeng, "Computing multiple roots of inexact polynomials" (2005).
    """
    allowed = COEFFICIENT_ROUNDING * len(roots) * np.abs(polynomial[0] * np.poly(-np.abs(roots)))
    found = roots
    for loose in LOOSE:
        found, joined = _grouped(polynomial, roots, loose * allowed)
        if not joined:
            break
        moved = _moved(polynomial, found, allowed)
        if np.all(_gap(polynomial, moved) <= allowed):
            return moved
    return found


def _gap(polynomial: np.ndarray, roots: Poles) -> np.ndarray:
    return np.abs(polynomial[0] * np.poly(roots) - polynomial)


def _grouped(polynomial: np.ndarray, roots: Poles, allowed: np.ndarray) -> tuple[Poles, bool]:
    """The roots with groups that are one replaced by their means, and whether there are any."""
    found, joined = roots.copy(), False
    waiting = [np.arange(len(roots))]
    while waiting:
        group = waiting.pop()
        for same in _as_one(roots[group]):
            trial = found.copy()
            trial[group] = same
            alone = len(group) == 1 or (bool(np.any(same.imag)) and len(group) == 2 and _is_pair(roots[group]))
            if alone or np.all(_gap(polynomial, trial) <= allowed):
                found, joined = trial, joined or not alone
                break
        else:
            waiting += [group[part] for part in _parted(roots[group])]
    return found, joined


def _moved(polynomial: np.ndarray, roots: Poles, allowed: np.ndarray) -> Poles:
    """The distinct roots moved so that the coefficients, each beside what is allowed, are met as well as may be."""
    each, where, copies = np.unique(roots, return_inverse=True, return_counts=True)
    for _ in range(REFINED):
        slopes = np.column_stack([-count * np.poly(np.delete(each[where], np.argmax(where == k))) for k, count in enumerate(copies)])
        gap = polynomial / polynomial[0] - np.poly(each[where])
        weight = np.abs(polynomial[0]) / allowed[1:]
        each = each + np.linalg.lstsq(slopes * weight[:, None], gap[1:] * weight, rcond=None)[0]
        each = _mirrored(each, roots[np.unique(where, return_index=True)[1]])
    return each[where]


def _mirrored(moved: Poles, before: Poles) -> Poles:
    """Real roots real again, and each complex one the exact conjugate of its partner before it moved."""
    partner = np.array([int(np.flatnonzero(before == z.conjugate())[0]) for z in before])
    return (moved + moved[partner].conj()) / 2


def _as_one(group: Poles) -> list[Poles]:
    """What a group may be if it is one root: a real one, and a pair where all are complex."""
    real = np.full(len(group), group.real.mean() + 0j)
    upper = group.imag > 0
    if len(group) == 1 or 2 * np.count_nonzero(upper) != len(group):
        return [real]
    mean = complex(group.real.mean(), np.abs(group.imag).mean())
    pair = np.where(upper, mean, mean.conjugate())
    return [real, pair]


def _is_pair(group: Poles) -> bool:
    return bool(abs(group[0] - group[1].conjugate()) <= SAME_ROOT_RTOL * abs(group[0]) < 1e3 * abs(group[0].imag))


def _parted(group: Poles) -> tuple[np.ndarray, np.ndarray]:
    """The two halves of a group with the widest gap between them, a root and its mirror image counting as one place."""
    points = group.real + 1j * np.abs(group.imag)
    apart = np.abs(points[:, None] - points)
    inside, edges = np.zeros(len(group), dtype=bool), []
    inside[0] = True
    for _ in range(len(group) - 1):  # Prim's shortest tree
        reach = np.where(inside[:, None] & ~inside, apart, np.inf)
        a, b = np.unravel_index(int(reach.argmin()), reach.shape)
        edges.append((float(reach[a, b]), int(a), int(b)))
        inside[b] = True
    edges.remove(max(edges))
    side = {0}
    for _ in edges:
        side |= {k for _, a, b in edges for k in (a, b) if a in side or b in side}
    here = np.isin(np.arange(len(group)), list(side))
    return np.flatnonzero(here), np.flatnonzero(~here)
