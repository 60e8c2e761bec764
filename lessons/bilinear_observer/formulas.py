"""Write the live formulas of the eight design steps."""

from __future__ import annotations

import numpy as np

from observer_lab.course.lesson import Formula
from observer_lab.engine.observers import BilinearForm, BilinearObserver

from ..toolkit.latex import MOST_ENTRIES, matrix, number, pole_words
from .paper_example import base_of, pole_of

BLOCK_MATRIX = r"\begin{bmatrix} FT_2 & AT_3 & FT_3 \end{bmatrix}"
BLOCKS = r"\begin{bmatrix} F_jT_2 & AT_3 & F_jT_3 \end{bmatrix}_{j=1,\ldots,%d}"  # of several inputs
P = "(V_2 - LV_1)"
EMPTY = r"\varnothing"


def _shown(M: np.ndarray, digits: int = 4) -> str:
    return matrix(M, digits) if M.size else EMPTY


def _is(name: str, left: str, M: np.ndarray, digits: int = 4) -> Formula:
    """The present entries of a matrix, its size where they are too many to read."""
    return Formula(name, f"{left} = {_shown(M, digits)}" if M.size <= MOST_ENTRIES else
                   rf"{left}: \; {M.shape[0]} \times {M.shape[1]}, \; \| {left} \| = {number(float(np.linalg.norm(M, 2)), digits)}")


def formulas_of(o: BilinearObserver, L: np.ndarray, plain: BilinearForm, step: int) -> tuple[Formula, ...]:
    """The equations of one step with their present entries; L (1×m) and `plain` are what runs."""
    c, k = o.canonical_Q, o.plant.inputs
    block, times = (BLOCK_MATRIX, "uF") if k == 1 else (BLOCKS % k, r"\textstyle\sum_j u_jF_j")
    match step:
        case 1:
            return (Formula("x", r"x = T_1 y + T_2 \mu + T_3 \eta"), _is("K1", r"K_1 = K \bar C^R", o.K1),
                    _is("T2", r"T_2^{\mathsf T}", o.T[1].T, 3), _is("T3", r"T_3^{\mathsf T}", o.T[2].T, 3), _is("V2", "V_2", o.V[1], 3))
        case 2:
            return (Formula("Q", rf"Q = V_1 {block}"), _is("Qn", "Q", o.Q, 3), _is("QL", r"\bar Q^L", c.zero_left, 3),
                    _is("QR", r"\bar Q^R", c.zero_right, 3), _is("Qs", r"\tilde Q^{\mathsf T}", c.summary.T, 3))
        case 3:
            defect = o.defect if o.case == 1 else np.zeros_like(o.defect)
            return (Formula("14", rf"\dot w = {P}(AT_2 + {times}T_2)\,w - {P}(AT_3 + {times}T_3)\,\eta"),
                    Formula("W", rf"W = V_2 {block}"), Formula("21", r"W \bar Q^R = 0 \;?"), _is("right", "W", o.right, 3),
                    _is("defect", r"W \bar Q^R", defect, 3))
        case 4:
            return (Formula("W", rf"W = V_2 {block}"), Formula("22", r"L = W \tilde Q + \pi \bar Q^L"),
                    _is("base", r"W \tilde Q", base_of(o)),
                    _is("QL", r"\bar Q^L", c.zero_left, 3))
        case 5:
            return (Formula("star", r"A_L = (A^* - B^* \pi^{\mathsf T})^{\mathsf T}"), _is("A", "A^*", o.A_star), _is("B", "B^*", o.B_star))
        case 6:
            return _sixth(o)
        case 7:
            return _seventh(o, L)
    return _eighth(plain)


def _sixth(o: BilinearObserver) -> tuple[Formula, ...]:
    if o.pi is None:
        return (Formula("none", r"\pi = " + EMPTY),)
    a, b, p = o.A_star.item(), o.B_star.item(), o.asked[0].real
    less = f"+ {number(-p, 4)}" if p < 0 else f"- {number(p, 4)}"
    return (
        Formula("place", r"A^* - B^* \pi = p"),
        Formula("pi", rf"\pi = \frac{{{number(a, 4)} {less}}}{{{number(b, 4)}}} = {number(o.pi.item(), 4)}"),
    )


def _seventh(o: BilinearObserver, L: np.ndarray) -> tuple[Formula, ...]:
    off = [(0, i) for i in range(L.shape[1]) if o.L is None or abs(L[0, i] - o.L[0, i]) > 0.01]
    return (
        Formula("L", rf"L = {matrix(L, 4, off)}"),
        Formula("A_L", rf"(V_2 - LV_1)AT_2 = {number(pole_of(o, L), 4)}"),
    )


def _eighth(plain: BilinearForm) -> tuple[Formula, ...]:
    return (
        Formula("18", r"\dot\chi = p\chi + Y y + b u + u\,U y"),
        Formula("19", r"\hat g = G y + \chi"),
        Formula("p", rf"p = {number(plain.A.item(), 5)}, \quad b = {number(plain.B.item(), 4)}"),
        Formula("Y", rf"Y^{{\mathsf T}} = {_shown(plain.Y.T, 5)}, \; U^{{\mathsf T}} = {_shown(plain.U.T, 4)}"),
        Formula("G", rf"G = {_shown(plain.G_y, 4)}"),
    )


def own_formulas(o: BilinearObserver, L: np.ndarray, plain: BilinearForm, pi: np.ndarray | None, poles: np.ndarray,
                 step: int) -> tuple[Formula, ...]:
    """The same for an observer of any order: π (q×k) that runs and the poles it leads to."""
    if step < 6:
        return formulas_of(o, L, plain, step)
    reached = Formula("A_L", rf"\mathrm{{eig}}\,(V_2 - LV_1)AT_2 = \{{{_poles(poles)}\}}")
    if step == 6:
        none = Formula("none", r"\pi = " + EMPTY)
        return (Formula("place", r"A^* - B^* \pi^{\mathsf T}"), none if pi is None else _is("pi", r"\pi", pi), reached)
    if step == 7:
        return (_is("L", "L", L), reached)
    return (
        Formula("18", r"\dot\chi = A_L\chi + Y y + b u + " + (r"u\,U y" if o.plant.inputs == 1 else r"\textstyle\sum_j u_jU_j y")),
        Formula("19", r"\hat g = G y + H\chi"),
        _is("AL", "A_L", plain.A), _is("Y", "Y", plain.Y), _is("b", "b", plain.B), _is("U", "U", plain.U), _is("G", "G", plain.G_y),
        _is("H", "H", plain.G_z),
    )


def _poles(poles: np.ndarray) -> str:
    words = pole_words([complex(p) for p in poles][:6]).replace("−", "-").replace("±", r"\pm ")
    return words + (r", \ldots" if len(poles) > 6 else "")
