"""Write the live formulas of the examples, in our sign and in the paper's."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from observer_lab.course.lesson import Design, Formula
from observer_lab.engine.observers import FunctionalObserver
from observer_lab.text import text

from ..toolkit.latex import matrix, number
from .knobs import EXAMPLE_FOUR, EXAMPLE_ONE, EXAMPLE_THREE, EXAMPLE_TWO

LAWS = MappingProxyType({
    EXAMPLE_ONE: r"F = s,\; T = [1 \;\; s],\; L = -s^2-4s-3",
    EXAMPLE_TWO: r"F = W\,\mathrm{diag}(s_1, s_2)\,W^{-1}",
    EXAMPLE_THREE: r"F = \mathrm{diag}(s_1, s_2),\; N = (K - M'C)\,T^{-1},\; M = M'",
    EXAMPLE_FOUR: r"t = [\,s\,t_2 \;\; t_2 \;\; s \;\; 1\,],\; t_2 = 1 + s^2/9,\; l = [\,l_1 \;\; 0\,]",
})


def formulas_of(design: Design, o: FunctionalObserver) -> tuple[Formula, ...]:
    """The law of an example, J, and the matrices of the observer with both signs."""
    sign = text("The paper prints u = +K x. Here u = −K x̂: its K, N and M change sign; F, T and L do not.")
    law = LAWS[design["example"]]
    return (
        Formula("law", law),
        Formula("J", rf"J = \textstyle\sum_i \alpha_i\|TA_i\| + \beta\|LC_i\| + \gamma\|MC_i\|, \quad J = {number(o.J, 4)}"),
        Formula("F", rf"F = {matrix(o.F)}, \quad L = {matrix(o.L)}"),
        Formula("T", rf"T = {matrix(o.T)}"),
        Formula("house", rf"u = -(Nz + My) + v: \; N = {matrix(o.N)}, \; M = {_direct(o.M)}"),
        Formula("paper", rf"u = +(Nz + My) + v: \; N = {matrix(-o.N)}, \; M = {_direct(-o.M)}", sign),
    )


def _direct(M: np.ndarray) -> str:
    """M as a number for one output, else as a row."""
    return number(float(M[0, 0])) if M.size == 1 else matrix(M)
