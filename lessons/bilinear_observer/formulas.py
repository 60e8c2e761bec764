"""The live formulas of each of the eight steps."""

from __future__ import annotations

import numpy as np

from app.engine import BilinearForm, BilinearObserver
from app.lesson import Formula

from ..toolkit import matrix, number
from .page import base_of, pole_of

BLOCK = r"\begin{bmatrix} FT_2 & AT_3 & FT_3 \end{bmatrix}"
EMPTY = r"\varnothing"
ROW = rf"W = V_2 {BLOCK}"


def _shown(M: np.ndarray, digits: int = 4) -> str:
    return matrix(M, digits) if M.size else EMPTY


def formulas_of(o: BilinearObserver, L: np.ndarray, plain: BilinearForm, step: int) -> tuple[Formula, ...]:
    """The equations of one step with their present entries; L (1×m) and `plain` are what runs."""
    if step <= 6:
        return (_first, _second, _third, _fourth, _fifth, _sixth)[step - 1](o)
    return _seventh(o, L) if step == 7 else _eighth(plain)


def _first(o: BilinearObserver) -> tuple[Formula, ...]:
    return (
        Formula("x", r"x = T_1 y + T_2 \mu + T_3 \eta"),
        Formula("K1", rf"K_1 = K \bar C^R = {_shown(o.K1)}"),
        Formula("T2", rf"T_2^{{\mathsf T}} = {_shown(o.T[1].T, 3)}"),
        Formula("T3", rf"T_3^{{\mathsf T}} = {_shown(o.T[2].T, 3)}"),
        Formula("V2", rf"V_2 = {_shown(o.V[1], 3)}"),
    )


def _second(o: BilinearObserver) -> tuple[Formula, ...]:
    c = o.canonical_Q
    return (
        Formula("Q", rf"Q = V_1 {BLOCK}"),
        Formula("Qn", rf"Q = {_shown(o.Q, 3)}"),
        Formula("QL", rf"\bar Q^L = {_shown(c.zero_left, 3)}"),
        Formula("QR", rf"\bar Q^R = {_shown(c.zero_right, 3)}"),
        Formula("Qs", rf"\tilde Q^{{\mathsf T}} = {_shown(c.summary.T, 3)}"),
    )


def _third(o: BilinearObserver) -> tuple[Formula, ...]:
    return (
        Formula("W", ROW),
        Formula("21", r"W \bar Q^R = 0 \;?"),
        Formula("right", rf"W = {_shown(o.right, 3)}"),
        Formula("defect", rf"W \bar Q^R = {_shown(np.zeros_like(o.defect) if o.case != 1 else o.defect, 3)}"),
    )


def _fourth(o: BilinearObserver) -> tuple[Formula, ...]:
    return (
        Formula("W", ROW),
        Formula("22", r"L = W \tilde Q + \pi \bar Q^L"),
        Formula("base", rf"W \tilde Q = {_shown(base_of(o))}"),
        Formula("QL", rf"\bar Q^L = {_shown(o.canonical_Q.zero_left, 3)}"),
    )


def _fifth(o: BilinearObserver) -> tuple[Formula, ...]:
    return (
        Formula("star", r"A_L = (A^* - B^* \pi^{\mathsf T})^{\mathsf T}"),
        Formula("A", rf"A^* = {_shown(o.A_star)}"),
        Formula("B", rf"B^* = {_shown(o.B_star)}"),
    )


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
