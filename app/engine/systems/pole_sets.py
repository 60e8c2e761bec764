"""Handle sets of poles: compute, check, match two sets, move one pole."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from .errors import PoleError
from .gates.argument_checks import COMPLEX, INTEGER, POLES, array, count, items, number, takes

__all__ = ["Poles", "check_poles", "match_poles", "move_pole", "pair_conjugates", "pole_text", "sorted_poles"]

Poles = npt.NDArray[np.complex128]

PAIR_TOLERANCE = 1e-9  # how far a pole may be from the conjugate of its partner, relative to its size
MIN_POLE = 1e-100  # the size below which no pole is told apart from 0
MAX_POLE = 1e100  # beyond this squares of a pole leave the range of doubles; no smaller limit would hold in any unit of time


@takes(A=array("… n n"))
def sorted_poles(A: np.ndarray) -> Poles:
    """eig(A) of a square matrix, or of each in a stack (…, n, n): complex, sorted by (real, imag)."""
    return np.sort_complex(np.linalg.eigvals(A).astype(complex))


@takes(pole=COMPLEX)
def pole_text(pole: complex) -> str:
    """A pole as a short human-readable number: 2, -1.5, -1 + 2j."""
    pole = complex(pole)
    if abs(pole.imag) <= 1e-12 * abs(pole):
        return f"{pole.real + 0.0:.6g}"
    return f"{pole.real + 0.0:.6g} {'+' if pole.imag > 0 else '-'} {abs(pole.imag):.6g}j"


@takes(poles=POLES, count=count())
def check_poles(poles: Iterable[complex], count: int) -> Poles:
    """The request as `count` complex numbers, conjugate pairs made exact, in the order given.

    Raises PoleError for a wrong number, NaN, infinity, absurd size, or a complex pole without its conjugate.
    """
    try:
        given = poles if isinstance(poles, np.ndarray) else list(poles)
        asked = np.asarray(given, dtype=np.complex128).ravel()
    except (TypeError, ValueError) as problem:
        raise PoleError("The poles must be numbers, real or complex.") from problem
    if asked.size != count:
        raise PoleError("Give one pole for each state: {count}, not {asked_size}.",
                        count=count, asked_size=asked.size)
    if not np.all(np.isfinite(asked)):
        raise PoleError("A requested pole is NaN or infinite; every pole must be a finite number.")
    if asked.size and np.abs(asked).max() > MAX_POLE:
        raise PoleError("A requested pole is larger than {largest:g}; ask for slower poles.", largest=MAX_POLE)
    return pair_conjugates(asked)


@takes(poles=POLES, rtol=number(0), floor=number(0))
def pair_conjugates(poles: Iterable[complex], *, rtol: float = PAIR_TOLERANCE, floor: float = 0.0) -> Poles:
    """The poles in the order given, near-real ones made real and near-conjugate pairs exact.

    `rtol` is how far a pole may be from the conjugate of its partner, relative to its size or to `floor` where that is larger.
    Raises PoleError where a partner is missing.

    >>> pair_conjugates([-1 + 2.0000000001j, -3, -1 - 2j])
    array([-1.+2.j, -3.+0.j, -1.-2.j])
    """
    asked = np.array(list(poles), dtype=np.complex128)
    size = np.maximum(np.abs(asked), max(MIN_POLE, floor))
    near_real = np.abs(asked.imag) <= PAIR_TOLERANCE * size
    asked[near_real] = asked[near_real].real
    lower = [i for i in range(asked.size) if asked[i].imag < 0]
    for i in (i for i in range(asked.size) if asked[i].imag > 0):
        partner = min(lower, key=lambda j: abs(asked[j] - asked[i].conjugate()), default=None)
        if partner is None or abs(asked[partner] - asked[i].conjugate()) > rtol * size[i]:
            raise _unpaired(asked[i])
        asked[partner] = asked[i].conjugate()
        lower.remove(partner)
    if lower:
        raise _unpaired(asked[lower[0]])
    return asked


def _unpaired(pole: complex) -> PoleError:
    return PoleError("The complex pole {pole} lacks its conjugate {pole2}: a real gain moves complex poles in "
                     "pairs, so ask for both.",
                     pole=pole_text(pole), pole2=pole_text(pole.conjugate()))


@takes(a=POLES, b=POLES)
def match_poles(a: Sequence[complex] | np.ndarray, b: Sequence[complex] | np.ndarray) -> tuple[np.ndarray, float]:
    """Match two sets of equally many poles by least total distance.

    Returns the order of `b`, so that b[order[i]] belongs to a[i], and the largest distance |a[i] − b[order[i]]|.
    Sorting would tear conjugate pairs and multiple poles apart; the assignment problem does not.
    Raises PoleError where the sets differ in size.
    """
    first, second = np.asarray(a, dtype=complex).ravel(), np.asarray(b, dtype=complex).ravel()
    if first.size != second.size:
        raise PoleError("A set of {first_size} poles cannot be matched with a set of {second_size}; give equally "
                        "many.",
                        first_size=first.size, second_size=second.size)
    if first.size == 0:
        return np.empty(0, dtype=int), 0.0
    distance = np.abs(first[:, None] - second[None, :])
    rows, columns = linear_sum_assignment(distance)
    return columns, float(distance[rows, columns].max())


@takes(poles=POLES, index=INTEGER, to=COMPLEX, axis_snap=number(0), fixed=items(count()))
def move_pole(
    poles: Sequence[complex], index: int, to: complex, *, axis_snap: float = 0.0, fixed: Sequence[int] = ()
) -> tuple[complex, ...]:
    """The set after pole `index` was dragged to `to`; the set stays closed under conjugation.

    A pair moves together. A pole of a pair dragged within `axis_snap` of the real axis makes both real. A real pole
    dragged off the axis takes the nearest other real pole along as its conjugate, or stays on the axis if there is
    none. Indices in `fixed` never move. Raises PoleError for an index or a target that makes no sense.
    """
    moved = [complex(pole) for pole in poles]
    to = complex(to)
    if not 0 <= index < len(moved):
        raise PoleError("There is no pole number {index}; the set has {count}.", index=index, count=len(moved))
    if not np.isfinite(to):
        raise PoleError("A pole can only be moved to a finite place.")
    partner = _partner(moved, index)
    if index in fixed or partner in fixed:
        return tuple(moved)
    on_axis = abs(to.imag) < axis_snap or abs(to.imag) <= PAIR_TOLERANCE * max(abs(to), MIN_POLE)
    if partner is None and not on_axis:
        partner = _nearest_real(moved, index, to, fixed)
        on_axis = partner is None
    moved[index] = complex(to.real, 0.0) if on_axis else to
    if partner is not None:
        moved[partner] = moved[index].conjugate() if not on_axis else complex(to.real, 0.0)
    return tuple(moved)


def _partner(poles: list[complex], index: int) -> int | None:
    """Index of the conjugate of a complex pole; equal pairs are told apart by their order in the set."""
    here = poles[index]
    if here.imag == 0:
        return None
    for tolerance in (0.0, PAIR_TOLERANCE * abs(here)):
        same = [i for i, pole in enumerate(poles) if abs(pole - here) <= tolerance]
        conjugate = [i for i, pole in enumerate(poles) if abs(pole - here.conjugate()) <= tolerance]
        if len(conjugate) == len(same):
            return conjugate[same.index(index)]
    raise _unpaired(here)


def _nearest_real(poles: list[complex], index: int, to: complex, fixed: Sequence[int]) -> int | None:
    free = [i for i, pole in enumerate(poles) if i != index and i not in fixed and pole.imag == 0]
    return min(free, key=lambda i: abs(poles[i] - to), default=None)
