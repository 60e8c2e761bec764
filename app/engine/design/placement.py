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
from ..systems.gates.argument_checks import POLES, matrix, optional, takes, vector
from ..systems.pole_sets import Poles, check_poles, match_poles, move_pole, pole_text
from ..systems.records import record
from ..systems.stability import poles_within
from .eigenstructure import controllable_split, input_factors, place_by_deflation
from .gain_record import ActsAsGain
from .robust import place_robustly

__all__ = ["Placement", "match_poles", "move_pole", "observer_gain", "place"]

SAME_POLE = 1e-5  # a fixed pole counts as requested within this distance, relative to its size
TURNED = 100  # times rounding of A, by which the staircase may move a fixed pole
WORSE_EIGENVECTORS = 3.0  # a gain by deflation is taken where it is 1 + 3 times smaller, for its eigenvectors are as they come,
POOR_EIGENVECTORS = 1e9  # or 1 + 1 times where the robust ones are as poor as this; beside a multiple pole by this condition alone
OTHER_STATES = 1.5  # where sizes of states are given, a gain found in other states is taken where it is so many times smaller
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


@takes(A=matrix(), B=matrix(), poles=POLES, sizes=optional(vector()))
def place(A: object, B: object, poles: Iterable[complex], *, sizes: object | None = None) -> Placement:
    """State-feedback gain K (m×n) with eig(A − BK) = poles, u = −Kx.

    A is n×n, B n×m; n poles closed under conjugation, of any multiplicity. With several inputs the freedom left is
    used to make the eigenvectors well conditioned (start: Kautsky, Nichols and Van Dooren 1985), in states balanced with the
    inputs, so that no unit of a state or an input changes the feedback. `sizes` (n,) of the states that count as alike take
    the place of these, ones for the units given. Uncontrollable modes must be among the
    poles. Raises PoleError with the reason where no gain exists, ShapeError where shapes
    disagree.

    >>> np.round(place([[0, 1], [0, 0]], [[0], [1]], [-1, -2]).gain, 6)
    array([[2., 3.]])
    """
    matrices = _checked_pair(A, B, "A", "B")
    return _place(*matrices, poles, _Wording(phrase("uncontrollable"), "K"), _sizes(sizes, len(matrices[0])))


@takes(A=matrix(), C=matrix(), poles=POLES, sizes=optional(vector()))
def observer_gain(A: object, C: object, poles: Iterable[complex], *, sizes: object | None = None) -> Placement:
    """Observer gain L (n×p) with eig(A − LC) = poles, by duality: L = place(Aᵀ, Cᵀ, poles, sizes=1/sizes).gainᵀ.

    A is n×n, C p×n, `sizes` (n,) as `place` takes them. Raises as `place` does, with unobservable in place of uncontrollable.

    >>> np.round(observer_gain([[0, 1], [0, 0]], [[1, 0]], [-1, -2]).gain.T, 6)
    array([[3., 2.]])
    """
    C = as_checked(C)
    A_dual, C_dual = _checked_pair(as_checked(A).T, C.T, "Aᵀ", "Cᵀ")
    alike = _sizes(sizes, len(A_dual))
    dual = _place(A_dual, C_dual, poles, _Wording(phrase("unobservable"), "L"), None if alike is None else 1 / alike)
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


def _sizes(sizes: object | None, n: int) -> np.ndarray | None:
    found = None if sizes is None else as_checked(sizes)
    if found is not None and (len(found) != n or not found.min() > 0):
        raise ShapeError("The sizes must be {n} positive numbers, one for each state.", n=n)
    return found


def _place(A: np.ndarray, B: np.ndarray, poles: Iterable[complex], words: _Wording, sizes: np.ndarray | None) -> Placement:
    n = A.shape[0]
    asked = check_poles(poles, n)
    scales = state_scale(A, B) if B.shape[1] == 1 else balance(A, B).unrounded[:n]
    A_balanced, B_balanced = A * (scales / scales[:, None]), B / scales[:, None]
    Q, reachable = controllable_split(A_balanced, B_balanced)
    if reachable == n:
        K, condition = _gain(A, B, asked, scales) if sizes is None else _gain_in(sizes, A, B, asked)
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

    With freedom left, the robust gain is compared by `_price` with one by deflation. Both are found and judged in the balanced
    states x / scales, so they know no units.
    """
    a, b = A * (scales / scales[:, None]), B / scales[:, None]

    rank = input_factors(b)[0].shape[1]
    multiplicity = max(int(np.count_nonzero(asked == pole)) for pole in asked)
    if multiplicity > rank or rank == 1:
        return place_by_deflation(a, b, asked) / scales, np.inf if multiplicity > rank else None
    K, condition = place_robustly(a, b, asked)
    if rank < len(a):
        other = place_by_deflation(a, b, asked)
        inputs = _input_sizes(a, b, asked)
        price, least = (_price(a, b, gain, asked, inputs) for gain in (K, other))
        better = 1 / (float(multiplicity == 1) / WORSE_EIGENVECTORS + condition / POOR_EIGENVECTORS)
        if not np.isfinite(condition) or (1 + better) * least < price:
            return other / scales, np.inf if multiplicity > 1 else None
    return K / scales, None


def _gain_in(sizes: np.ndarray, A: np.ndarray, B: np.ndarray, asked: Poles) -> tuple[np.ndarray, float | None]:
    """Of the robust gain in states of these sizes and the gain of `_gain` the smaller one, the second counting 1.5 times."""
    scales = balance(A, B).unrounded[:len(A)]
    K, condition = _gain(A, B, asked, scales)
    a, b = A * (sizes / sizes[:, None]), B / sizes[:, None]
    own, good = place_robustly(a, b, asked) if input_factors(b)[0].shape[1] > 1 else (K, np.inf)
    if not np.isfinite(good):
        return K, condition
    alike = np.ones(B.shape[1])
    if OTHER_STATES * _price(a, b, K * sizes, asked, alike) < _price(a, b, own, asked, alike):
        return K, condition
    return own / sizes, None


def _input_sizes(A: np.ndarray, B: np.ndarray, asked: Poles) -> np.ndarray:
    """How far each input (m,) of amplitude one moves the states at the speed of the poles asked for."""
    speed = float(np.abs(asked).max()) or float(np.linalg.norm(A, 2)) or 1.0
    moved = np.linalg.lstsq(speed * (1 + 1j) * np.eye(len(A)) - A, B.astype(complex), rcond=None)[0]
    return np.linalg.norm(moved, axis=0)


def _price(A: np.ndarray, B: np.ndarray, K: np.ndarray, asked: Poles, inputs: np.ndarray) -> float:
    """‖K‖ with each input in units of what it moves, times 1 + miss / (1e-6 of the largest pole)."""
    size = max(float(np.abs(asked).max()), float(np.finfo(float).tiny))
    with np.errstate(all="ignore"):
        price = float(np.linalg.norm(inputs[:, None] * K)) if np.isfinite(K).all() else np.inf
        price = price * (1 + _miss(A, B, K, asked) / (ALLOWED_MISS * size)) if np.isfinite(price) else np.inf
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
