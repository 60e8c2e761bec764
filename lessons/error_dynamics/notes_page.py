"""Check one page of the observer notes (001) line by line and show where each slip leads.

The notes ask for both poles at −1 of the spring-damper m = 1, b = 0.5, k = 1 with C = [1 0]. They print the
characteristic polynomial, two matching equations, the gain and A − LC.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np

from observer_lab.course.figures.records import Figure, PlaneFigure, Point, TableFigure
from observer_lab.engine import Plant
from observer_lab.plants import spring_damper
from observer_lab.text import Text, format_number, joined, text

PLANT = spring_damper.MODEL.plant
TARGET = (-1.0, -1.0)
RIGHT_GAIN = np.array([[1.5], [-0.75]])
PRINTED_GAIN = np.array([[2.5], [-1.25]])
PRINTED_MATRIX = np.array([[-2.5, 1.0], [-0.25, -0.5]])
NOTES_TAB = text("Notes")
ON_AXIS = 1e-12  # 1/s: a real part below it is zero
NONE, POLYNOMIAL_LINE, FIRST_LINE, SECOND_LINE, GAIN_LINE, MATRIX_LINE = "none", "polynomial", "first", "second", "gain", "matrix"
REPORT_LINES = (
    (NONE, text("none yet")),
    (POLYNOMIAL_LINE, text("the polynomial")),
    (FIRST_LINE, text("the first matching equation")),
    (SECOND_LINE, text("the second matching equation")),
    (GAIN_LINE, text("the gain")),
    (MATRIX_LINE, text("the matrix A − LC")),
)
OTHER_SENSOR = text("The notes measure the position; here L is the gain for that sensor.")
PRINTED_FORMULAS = MappingProxyType({
    POLYNOMIAL_LINE: "λ² + (l₁ + 0.5)λ + 1 + 0.5 l₁ + l₂",
    FIRST_LINE: "l₁ − 0.5 = 2",
    SECOND_LINE: "1 + 0.5 l₁ + l₂ = 1",
    GAIN_LINE: "L = (2.5, −1.25)",
    MATRIX_LINE: "[−2.5, 1; −0.25, −0.5]",
})


def printed_model() -> Plant:
    """The plant that the printed pair believes in: x̂̇ = M x̂ + B u + L y is an observer of A = M + L C, its k 1.5."""
    return Plant(PRINTED_MATRIX + PRINTED_GAIN @ PLANT.C, PLANT.B, PLANT.C, name="as the notes print it")


def poles_of(M: np.ndarray) -> np.ndarray:
    """Both eigenvalues of M (2×2), sorted; a double pole comes out exactly, which eigvals does not promise."""
    half = float(np.trace(M)) / 2
    root = np.sqrt(complex(half**2 - (M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0])))
    return np.sort_complex(np.array([half - root, half + root]))


def taken_at_its_word(line: str, L: np.ndarray) -> np.ndarray:
    """The poles that follow from one printed line: its gain or matrix, else those of the present L (2×1)."""
    closed = {FIRST_LINE: PLANT.A - PRINTED_GAIN @ PLANT.C, GAIN_LINE: PLANT.A - PRINTED_GAIN @ PLANT.C,
              SECOND_LINE: PLANT.A - RIGHT_GAIN @ PLANT.C, MATRIX_LINE: PRINTED_MATRIX}.get(line, PLANT.A - L @ PLANT.C)
    return poles_of(closed)


def notes_figures(line: str, L: np.ndarray, theirs: bool = True) -> tuple[Figure, Figure]:
    """The page line by line beside the present gain, and the poles that the doubted line leads to.

    `theirs`: the position is measured, as in the notes.
    """
    return tuple(figure if theirs else replace(figure, caption=joined(OTHER_SENSOR, figure.caption))  # type: ignore[return-value]
                 for figure in (_page(line, L), _poles(line, L)))


def _page(line: str, L: np.ndarray) -> TableFigure:
    l1, l2 = (float(v) for v in L[:, 0])
    A = PLANT.A - L @ PLANT.C
    trace, det = -float(np.trace(A)), float(np.linalg.det(A))
    yours = {
        POLYNOMIAL_LINE: f"λ² {signed(trace)}λ {signed(det)}",
        FIRST_LINE: _compared(l1 - 0.5, 2),
        SECOND_LINE: _compared(1 + 0.5 * l1 + l2, 1),
        GAIN_LINE: f"L = ({_plain(l1)}, {_plain(l2)})",
        MATRIX_LINE: f"[{_plain(A[0, 0])}, 1; {_plain(A[1, 0])}, −0.5]",
    }
    names = dict(REPORT_LINES)
    rows = tuple((text("▸ {names}", names=names[k]) if k == line else names[k], PRINTED_FORMULAS[k], yours[k])
                 for k in PRINTED_FORMULAS)
    return TableFigure("page", text("the page of the notes, line by line"),
                       (text("line"), text("printed"), text("with your L")), (*_before(L), *rows),
                       tab=NOTES_TAB, caption=text("The last column puts the present gain into each line; the "
                                                   "polynomial there is that of A − LC itself."))


def _before(L: np.ndarray) -> tuple[tuple[Text, str | Text, str], ...]:
    """Three statements before the example: e is no derivative, a condition on real parts, and a differential equation with its dot.

    Without its dot the equation gives at rest (u = 1, x = (1, 0)) the ẑ that solves (I − A + LC) ẑ = B u + L y.
    """
    A = PLANT.A - L @ PLANT.C
    poles, rate = poles_of(A), A[:, 0]
    largest = float(poles.real.max())
    still = np.eye(2) - A
    z = np.linalg.solve(still, PLANT.B[:, 0] + L[:, 0]) if abs(np.linalg.det(still)) > 1e-9 else np.full(2, np.inf)
    sign = "=" if abs(largest) < ON_AXIS else "<" if largest < 0 else ">"
    return (
        (text("the definition of the error"), "e := ẋ − x̂̇", f"e = (1, 0), ė = ({_plain(rate[0])}, {_plain(rate[1])})"),
        (text("the condition of convergence"), text("eigenvalues < 0"),
         f"s = {_words(poles)}; Re s = " + ("0" if sign == "=" else f"{_plain(largest)} {sign} 0")),
        (text("the equation of the observer, at rest with u = 1"), "ẑ = Aẑ + Bu + L(y − Cẑ)",
         f"ẑ = ({_plain(z[0])}, {_plain(z[1])}), x = (1, 0)"),
    )


def _poles(line: str, L: np.ndarray) -> PlaneFigure:
    poles = taken_at_its_word(line, L)
    points = (*(Point(p, 0.0, "reference", "circle") for p in TARGET),
              *(Point(float(p.real), float(p.imag), "estimate") for p in poles))
    words = _words(poles)
    met = bool(np.all(np.abs(poles - np.array(TARGET)) < 1e-6))
    name = dict(REPORT_LINES)[line]
    found = (text("With your L the poles are {words}", words=words) if line in (NONE, POLYNOMIAL_LINE) else
             text("Used as printed, {name} gives the poles {words}", name=name, words=words))
    said = text("{found}, as asked.", found=found) if met else text("{found}; asked were −1 and −1.", found=found)
    return PlaneFigure("word", text("poles if the line is used as printed"), (), points, "Re s",
                       "Im s", (-4.0, 1.0), (-2.0, 2.0), unstable=True, tab=NOTES_TAB,
                       caption=said)


def _words(poles: np.ndarray) -> str:
    if abs(poles[0].imag) > 1e-9:
        return f"{poles[1].real:.3f} ± {poles[1].imag:.3f}j".replace("-", "−")
    return f"{poles[0].real:.3f}, {poles[1].real:.3f}".replace("-", "−")


def _plain(value: float) -> str:
    return format_number(value + 0.0, ".4g")


def _compared(left: float, right: int) -> str:
    return f"{_plain(left)} {'=' if abs(left - right) < 1e-9 else '≠'} {right}"


def signed(value: float) -> str:
    """A term of a sum: + 2, − 0.333."""
    return f"{'−' if value < 0 else '+'} {format_number(abs(value), '.4g')}"
