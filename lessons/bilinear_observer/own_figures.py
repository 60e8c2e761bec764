"""Draw the tables for an own bilinear plant: the step, the conditions, what may be wanted."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import TableFigure
from observer_lab.course.lesson import Outcome
from observer_lab.engine.observers import BilinearObserver
from observer_lab.text import Text, format_number, joined, listed, same, text

from ..toolkit.boards import listed as in_pairs
from ..toolkit.latex import pole_words
from .figures import CASES_TAB, HEADINGS, STEPS_TAB, problems_table
from .own_plant import Here, Wanted
from .run_record import Setting
from .study import Study

MOST_CELLS = 12  # entries of a matrix that a table writes out
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


def own_steps(outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """The matrices of the step shown."""
    return (_step(outcome.study.setting, int(outcome.design["step"])),)


def own_cases(here: Here, outcome: Outcome[Study]) -> tuple[TableFigure, ...]:
    """Sizes and conditions, and what may be wanted of this plant."""
    return _conditions(here, outcome.study.observer), _wanted(here, outcome.design["wanted"])


def _step(s: Setting, step: int) -> TableFigure:
    """The matrices of the step shown: their sizes, and their entries where they are few."""
    o, c = s.solved, s.solved.canonical_Q
    shown = {1: (("V₂", o.V[1]), ("T₂ᵀ", o.T[1].T), ("T₃ᵀ", o.T[2].T)), 2: (("Q", o.Q), ("Q̄ᴸ", c.zero_left)),
             3: (("Q̄ᴿ", c.zero_right), ("W Q̄ᴿ", o.defect)), 4: (("Q̄ᴸ", c.zero_left),), 5: (("A*", o.A_star), ("B*", o.B_star)),
             6: (("A*", o.A_star), ("B*", o.B_star)), 7: (("L", s.L),),
             8: (("A_L", s.plain.A), ("Y", s.plain.Y), ("b", s.plain.B), ("U", s.plain.U), ("G", s.plain.G_y), ("H", s.plain.G_z))}[step]
    rows = tuple((same(name), f"{M.shape[0]} × {M.shape[1]}", _cells(M)) for name, M in shown)
    return TableFigure("step", HEADINGS[step - 1], (text("item"), text("size"), text("entries, row by row")), rows, tab=STEPS_TAB,
                       caption=text("The entries, in the units of the file; the formulas show larger matrices, of the largest the norm."))


def _cells(M: np.ndarray) -> str:
    return "—" if not M.size or M.size > MOST_CELLS else ", ".join(format_number(v, ".4g") for v in M.ravel()).replace("-", "−")


def _conditions(here: Here, o: BilinearObserver) -> TableFigure:
    n, m, q = o.plant.n, o.plant.m, o.order
    left = len(o.canonical_Q.zero_left)
    rows = (
        (text("input u"), listed(here.names)),
        (text("what u multiplies"), text("nothing: F is zero") if here.linear else same(_terms(o.plant.inputs))),
        (text("states n, sensors m, numbers wanted r"), f"{n}, {m}, {len(o.K)}"),
        (text("order q of the observer"), str(q)),
        (text("order n − m of Luenberger's reduced observer"), str(n - m)),
        (text("rows and columns of Q"), f"{o.Q.shape[0]}, {o.Q.shape[1]}"),
        (text("rank of Q"), str(o.canonical_Q.rank)),
        (text("what is left of (21), relative"), text("{left:.1e}", left=o.defect_size) if o.defect_size else "0"),
        (text("rows of Q to spare"), str(left)),
    )
    lower = (text("Order {q} instead of n − m = {most}: the functional observer is the smaller one.", q=q, most=n - m) if q < n - m else
             text("Order {q} is that of Luenberger's reduced observer: all that is not measured is estimated.", q=q))
    if q < len(o.K):
        lower = joined(lower, text("Beyond what y says, the {rows} numbers wanted have rank {q}: r is {q} in "
                                   "the lights.", rows=len(o.K), q=q))
    return TableFigure("conditions", text("sizes and conditions"), (text("quantity"), text("value")), rows, tab=CASES_TAB, caption=lower)


def _terms(inputs: int) -> str:
    return "F x" if inputs == 1 else ", ".join(f"F{str(j + 1).translate(LOWERED)} x" for j in range(inputs))


def _wanted(here: Here, chosen: str) -> TableFigure:
    def pole(w: Wanted) -> Text:
        o = w.solved
        if o.case == 3 and not w.bolted:
            return text("any")
        fixed = w.bolted if o.case == 3 else tuple(in_pairs(o.reached))
        return same("—" if o.case == 1 else pole_words(fixed[:4]))
    wanted = here.wanted
    met = sum(w.solved.case != 1 for w in wanted)
    return problems_table(text("what may be wanted of this plant"), text("wanted"), [(w.label, w.solved, pole(w)) for w in wanted],
                          wanted.index(here.of(chosen)),
                          text("{met} of {count} have an L that frees ε from u and x.", met=met, count=len(wanted)), orders=True)
