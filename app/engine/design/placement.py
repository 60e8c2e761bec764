"""Place poles: K with the wanted eig(A − BK), and by duality the observer gain L."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from functools import cached_property

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..plotting import with_plot
from ..systems.arrays import as_checked, frozen
from ..systems.balance import balance, state_scale
from ..systems.errors import PoleError, ShapeError, phrase
from ..systems.exact_roots import MAX_STATES, exact_poles
from ..systems.gates.argument_checks import POLES, matrix, takes
from ..systems.pole_sets import Poles, check_poles, match_poles, move_pole, pole_text
from ..systems.records import record
from ..systems.stability import poles_within
from .eigenstructure import controllable_split, input_factors, place_by_deflation
from .gain_record import ActsAsGain
from .robust import place_pairs_robustly

__all__ = ["Placement", "match_poles", "move_pole", "observer_gain", "place"]

SAME_POLE = 1e-5  # a fixed pole counts as requested within this distance, relative to its size
TURNED = 100  # times rounding of A, by which the staircase may move a fixed pole
POOR_EIGENVECTORS = 1e9  # at this condition number a gain by deflation is taken where it costs half as much
WORTH_A_LOOK = 1e5  # below it deflation could not win
OTHER_STATES = 1.5  # a gain found in balanced states is taken where it is that much smaller: where both are alike, the states given count
ALLOWED_MISS = 1e-6  # of the largest pole: a gain that misses the poles by this counts as twice as large


@record()
class Placement(ActsAsGain):
    """A gain and what it achieves; it acts as its gain: `A - B @ place(A, B, poles)`.

    gain is K (m×n) from `place` and L (n×p) from `observer_gain`. condition is the 2-norm condition number of the
    closed-loop eigenvectors of unit length, infinite if they are not independent. fixed holds the poles no gain can move.
    """

    gain: np.ndarray
    asked: Poles
    condition: float
    fixed: Poles
    _pair: tuple[np.ndarray, np.ndarray, np.ndarray] = field(repr=False)  # A, B and K; of an observer the dual

    def __iter__(self) -> Iterator[np.ndarray]:
        return iter(self.gain)

    def __getitem__(self, place: object) -> np.ndarray:
        return self.gain[place]  # type: ignore[index]

    @cached_property
    def _told(self) -> tuple[Poles, float]:
        A, B, K = self._pair
        scale = state_scale(A, B)
        if len(A) > MAX_STATES:
            return _upper_bound(A - B @ K, self.asked)
        found = exact_poles(A, B, K, self.asked, scale)
        away = found.distances(self.asked)
        rows, order = linear_sum_assignment(away)
        return frozen(found.values[order]), float(away[rows, order].max())

    @property
    def reached(self) -> Poles:
        """eig(A − BK) of the gain as it stands, to rounding: reached[i] belongs to asked[i]."""
        return self._told[0]

    @property
    def error(self) -> float:
        """max |asked − reached|, of the eigenvalues that A − BK has, not of those that double precision finds. Copies of
        a multiple pole are apart where the rounding of the gain parts them. Beyond thirty states an upper bound."""
        return self._told[1]

    @property
    def poles(self) -> Poles:
        """The poles reached, sorted by (real, imag)."""
        return with_plot(np.sort_complex(self.reached))


def _upper_bound(closed: np.ndarray, asked: Poles) -> tuple[Poles, float]:
    """Eigenvalues in double precision, and the error with all that rounding may have added to it."""
    found, slack = poles_within(closed)
    order = match_poles(asked, found)[0]
    return frozen(found[order]), float((np.abs(asked - found[order]) + slack[order]).max())


@takes(A=matrix(), B=matrix(), poles=POLES)
def place(A: object, B: object, poles: Iterable[complex]) -> Placement:
    """State-feedback gain K (m×n) with eig(A − BK) = poles, u = −Kx.

    A is n×n, B n×m; n poles closed under conjugation, of any multiplicity. With several inputs the freedom left is
    used to make the eigenvectors well conditioned (start: Kautsky, Nichols and Van Dooren 1985), in the states given and
    in balanced ones; of these gains the one with the smaller ‖K‖_F in the units given is returned, that of the balanced
    states counting 1.5 times and a miss of the poles by 1e-6 of the largest as twice. Uncontrollable modes must be among the
    poles. Raises PoleError with the reason where no gain exists, ShapeError where shapes
    disagree.

    >>> np.round(place([[0, 1], [0, 0]], [[0], [1]], [-1, -2]).gain, 6)
    array([[2., 3.]])
    """
    matrices = _checked_pair(A, B, "A", "B")
    return _place(*matrices, poles, _Wording(phrase("uncontrollable"), "K"))


@takes(A=matrix(), C=matrix(), poles=POLES)
def observer_gain(A: object, C: object, poles: Iterable[complex]) -> Placement:
    """Observer gain L (n×p) with eig(A − LC) = poles, by duality: L = place(Aᵀ, Cᵀ, poles).gainᵀ.

    A is n×n, C p×n. Raises as `place` does, with unobservable in place of uncontrollable.

    >>> np.round(observer_gain([[0, 1], [0, 0]], [[1, 0]], [-1, -2]).gain.T, 6)
    array([[3., 2.]])
    """
    C = as_checked(C)
    A_dual, C_dual = _checked_pair(as_checked(A).T, C.T, "Aᵀ", "Cᵀ")
    dual = _place(A_dual, C_dual, poles, _Wording(phrase("unobservable"), "L"))
    return Placement(frozen(dual.gain.T), dual.asked, dual.condition, dual.fixed, dual._pair)


@record(eq=True)
class _Wording:
    hidden: str
    gain: str


def _checked_pair(A: object, B: object, a: str, b: str) -> tuple[np.ndarray, np.ndarray]:
    first, second = as_checked(A), as_checked(B)
    if not first.size:
        raise ShapeError("The plant has no states, so there is no gain to design.")
    if first.shape[0] != first.shape[1]:
        raise ShapeError("A must be square; it is {rows}×{columns}.", rows=first.shape[0], columns=first.shape[1])
    if second.shape[0] != first.shape[0]:
        raise ShapeError("{b} must have {rows} rows, as {a} has; it is {rows2}×{columns}.",
                         b=b, rows=first.shape[0], a=a, rows2=second.shape[0], columns=second.shape[1])
    return first, second


def _place(A: np.ndarray, B: np.ndarray, poles: Iterable[complex], words: _Wording) -> Placement:
    n = A.shape[0]
    asked = check_poles(poles, n)
    scales = state_scale(A, B)
    A_balanced, B_balanced = A * (scales / scales[:, None]), B / scales[:, None]
    Q, reachable = controllable_split(A_balanced, B_balanced)
    if reachable == n:
        K, condition = _gain(A, B, asked, scales if B.shape[1] == 1 else balance(A, B).unrounded[:n])
        return _judge(A, B, K, asked, condition, np.empty(0, dtype=complex))
    hidden = Q[:, reachable:]
    fixed, slack = poles_within(hidden.T @ A_balanced @ hidden)
    order = np.lexsort((fixed.imag, fixed.real))
    fixed = fixed[order]
    free = _without_fixed(asked, fixed, slack[order] + TURNED * n * np.finfo(float).eps * np.linalg.norm(A_balanced, 2), words)
    seen = Q[:, :reachable]
    K = np.zeros((B.shape[1], n))
    if reachable:
        K = _gain(seen.T @ A_balanced @ seen, seen.T @ B_balanced, free, np.ones(reachable))[0] @ seen.T / scales
    return _judge(A, B, K, asked, None, fixed)


def _without_fixed(asked: Poles, fixed: Poles, slack: np.ndarray, words: _Wording) -> Poles:
    """The request without the poles nobody can move; PoleError where one of them was not asked for. A request is for a fixed
    pole where it is within SAME_POLE of that pole's size, and what rounding of the plant can move it by (`slack`)."""
    left = list(asked)
    for mode, rounding in zip(fixed, slack, strict=True):
        nearest = min(range(len(left)), key=lambda i: abs(left[i] - mode))
        if abs(left[nearest] - mode) > SAME_POLE * abs(mode) + rounding:
            name = pole_text(mode)
            raise PoleError("The mode at {name} is {hidden}: no {gain} can move it, so keep {name} among the "
                            "requested poles.",
                            name=name, hidden=words.hidden, gain=words.gain)
        left.pop(nearest)
    return check_poles(left, len(left))


def _gain(A: np.ndarray, B: np.ndarray, asked: Poles, scales: np.ndarray) -> tuple[np.ndarray, float | None]:
    """Gain of a controllable pair and the condition of its eigenvectors (None: to be measured).

    With freedom left, robust gains found in the states given and in the balanced states x / scales, and one by deflation, are
    compared by `_price`. Each follows a change of units without a jump, so the least price does not jump either.
    """
    balanced = A * (scales / scales[:, None]), B / scales[:, None]

    def deflated() -> np.ndarray:
        return place_by_deflation(*balanced, asked) / scales

    rank = input_factors(balanced[1])[0].shape[1]
    multiplicity = max(int(np.count_nonzero(asked == pole)) for pole in asked)
    if multiplicity > rank:
        return deflated(), np.inf
    if rank == 1:
        return deflated(), None
    plain, turned = place_pairs_robustly([(A, B), balanced], asked)
    best = min(plain[1], turned[1])
    found: list[tuple[float, np.ndarray, float | None]] = [(_price(A, B, plain[0], asked), *plain)] if np.isfinite(plain[1]) else []
    if np.isfinite(turned[1]):
        found.append((OTHER_STATES * _price(A, B, turned[0] / scales, asked), turned[0] / scales, None))
    if best > WORTH_A_LOOK:
        K = deflated()
        found.append(((1 + POOR_EIGENVECTORS / best) * _price(A, B, K, asked), K, np.inf if multiplicity > 1 else None))
    _, K, condition = min(found, key=lambda one: one[0])
    return K, condition


def _price(A: np.ndarray, B: np.ndarray, K: np.ndarray, asked: Poles) -> float:
    """‖K‖ in the units given, times 1 + miss / (1e-6 of the largest pole): what the choice between gains is made by."""
    size = max(float(np.abs(asked).max()), float(np.finfo(float).tiny))
    with np.errstate(all="ignore"):
        price = float(np.linalg.norm(K)) * (1 + _miss(A, B, K, asked) / (ALLOWED_MISS * size)) if np.isfinite(K).all() else np.inf
    return price if np.isfinite(price) else np.inf


def _miss(A: np.ndarray, B: np.ndarray, K: np.ndarray, asked: Poles) -> float:
    return match_poles(asked, np.linalg.eigvals(A - B @ K))[1]


def _judge(
    A: np.ndarray, B: np.ndarray, K: np.ndarray, asked: Poles, condition: float | None, fixed: Poles
) -> Placement:
    if not np.all(np.isfinite(K)):
        raise PoleError("No finite gain reaches these poles: the plant is nearly uncontrollable; ask for poles "
                        "nearer to its own.")
    if condition is None:
        s = np.linalg.svd(np.linalg.eig(A - B @ K)[1], compute_uv=False)
        condition = float(s[0] / s[-1]) if s[-1] > asked.size * np.finfo(float).eps * s[0] else np.inf
    return Placement(frozen(K), frozen(asked), condition, frozen(fixed), (A, B, frozen(K)))
