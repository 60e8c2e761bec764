"""Compare the paper's worked example with ours, line by line, and show where a slip leads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from observer_lab.engine.observers import BilinearObserver
from observer_lab.plants.bilinear import POLE, PRINTED_L
from observer_lab.text import Text, same, text

NONE, FATAL = "none", "l4"


@dataclass(frozen=True)
class Line:
    """One printed line: its step, what it is, the digits as printed, ours, and the pole it leads to by itself."""

    id: str
    step: int
    name: Text
    printed: str
    ours: Callable[[BilinearObserver], np.ndarray | None]
    alone: Callable[[BilinearObserver], float] | None = None


def error_matrix(o: BilinearObserver, L: np.ndarray) -> np.ndarray:
    """A_L = (V₂ − L V₁) A T₂ (q×q) for any L."""
    return (o.V[1] - L @ o.V[0]) @ o.plant.A @ o.T[1]


def pole_of(o: BilinearObserver, L: np.ndarray) -> float:
    """A_L for any L (1×m), a number here."""
    return error_matrix(o, L).item()


def base_of(o: BilinearObserver) -> np.ndarray:
    """V₂ [F T₂, A T₃, F T₃] Q̃ (q×m), the part of L that does not depend on the pole."""
    return o.right @ o.canonical_Q.summary


def _swapped(entry: int) -> Callable[[BilinearObserver], float]:
    def alone(o: BilinearObserver) -> float:
        assert o.L is not None
        L = o.L.copy()
        L[0, entry] = PRINTED_L[0, entry]
        return pole_of(o, L)
    return alone


def _entry(entry: int) -> Callable[[BilinearObserver], np.ndarray | None]:
    return lambda o: None if o.L is None else o.L[:, entry]


def _divisor(o: BilinearObserver) -> float:
    assert o.pi is not None
    return pole_of(o, base_of(o) + o.pi @ np.array([[-0.64, 1.55, -1.28, 1.0]]))


def _by_pi(pi: float) -> Callable[[BilinearObserver], float]:
    return lambda o: pole_of(o, base_of(o) + pi * o.canonical_Q.zero_left)


def _plain(part: str) -> Callable[[BilinearObserver], np.ndarray | None]:
    return lambda o: None if o.without_derivative is None else getattr(o.without_derivative, part)


def _same_pole(o: BilinearObserver) -> float:
    return POLE


PRINTED_LINES = (
    Line("v2", 1, same("V₂"), "0, 0, 0, 0, 5, 6", lambda o: o.V[1]),
    Line("t2", 1, same("T₂ᵀ"), "0, 0, 0, 0, 0.2, 0", lambda o: o.T[1]),
    Line("t3", 1, same("T₃ᵀ"), "0, 0, 0, 0, −1.2, 1", lambda o: o.T[2] if o.T[2].shape[1] == 1 else None),
    Line("q1", 2, text("row 1 of Q"), "−0.40, 5.40, 2.40", lambda o: o.Q[0]),
    Line("q2", 2, text("row 2 of Q"), "0, 11.00, 1.00", lambda o: o.Q[1]),
    Line("q3", 2, text("row 3 of Q"), "0.20, −4.20, 0.80", lambda o: o.Q[2]),
    Line("q4", 2, text("row 4 of Q"), "0, −19.00, 1.00", lambda o: o.Q[3] if len(o.Q) == 4 else None),
    Line("divisor", 2, same("Q̄ᴸ"), "−0.64, 1.55, −1.28, 1.00",
         lambda o: o.canonical_Q.zero_left if o.canonical_Q.zero_left.size else None, _divisor),
    Line("defect", 3, text("columns of Q̄ᴿ"), "0", lambda o: np.array([float(o.canonical_Q.zero_right.shape[1])])),
    Line("family", 4, text("rows of Q̄ᴸ"), "1", lambda o: np.array([float(len(o.canonical_Q.zero_left))])),
    Line("star", 5, same("A*, B*"), "−6.47, 2.53",
         lambda o: np.array([o.A_star.item(), o.B_star.item()]) if o.B_star.size == 1 else None,
         _by_pi((-6.47 - POLE) / 2.53)),
    Line("pi", 6, same("π"), "9.29", lambda o: o.pi, _by_pi(9.29)),
    Line("l1", 7, same("L₁"), "−12.49", _entry(0), _swapped(0)),
    Line("l2", 7, same("L₂"), "17.68", _entry(1), _swapped(1)),
    Line("l3", 7, same("L₃"), "−18.99", _entry(2), _swapped(2)),
    Line("l4", 7, same("L₄"), "2.29", lambda o: None if o.L is None or o.L.shape[1] < 4 else o.L[:, 3], _swapped(3)),
    Line("chi-y", 8, text("y in χ̇"), "−273.64, −213.93, 408.38, −198.94", _plain("Y"), _same_pole),
    Line("chi-u", 8, text("χ̇: of u"), "8.85", _plain("B")),
    Line("chi-uy", 8, text("χ̇: of u y"), "−44.26, 27.98, −81.33, 36.08", _plain("U")),
    Line("g", 8, text("y in ĝ"), "−11.49, 19.68, −15.99, 13.29", _plain("G_y"), _same_pole),
)
DOUBTED = tuple(line for line in PRINTED_LINES if line.alone is not None)
OPTIONS = ((NONE, text("none yet")), *((line.id, line.name) for line in DOUBTED))


def words(values: np.ndarray | None, digits: int = 4) -> str:
    """Numbers as a cell of a table shows them: one digit or two more than the paper prints."""
    if values is None:
        return "—"
    cells = [f"{v:.{digits}f}".rstrip("0").rstrip(".") for v in np.ravel(values)]
    return ", ".join("0" if cell in ("-0", "") else cell for cell in cells).replace("-", "−")
