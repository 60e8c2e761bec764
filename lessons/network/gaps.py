"""Draw how a gap of packets weighs in the mean: its growth, its probability and their product."""

from __future__ import annotations

import numpy as np

from observer_lab.course.figures.records import Curve, PlaneFigure, Point
from observer_lab.course.lesson import Outcome
from observer_lab.text import same, text

from .study import Study

GAP_TAB = text("Gaps")
LONGEST_GAP, LEAST, MOST = 12, -12.0, 6.0  # packets; decades that are drawn at most


def gaps(outcome: Outcome[Study]) -> PlaneFigure:
    """Variance after a gap of k packets, the gap's probability, and the product that the mean adds up, in decades."""
    p, radius = float(outcome.design["loss"]), outcome.study.watched.sampled.radius
    k = np.arange(LONGEST_GAP + 1.0)
    growth, chance = 2 * k * np.log10(max(radius, 1e-9)), k * np.log10(max(p, 1e-9))
    lines = [np.clip(each, LEAST, MOST) for each in (growth, chance, growth + chance)]
    ratio = p * radius**2
    said = (text("p·max|λ|² = {ratio:.3g} < 1: the products shrink, and their sum is finite.", ratio=ratio) if ratio < 1 else
            text("p·max|λ|² = {ratio:.3g} ≥ 1: the products do not shrink, and their sum has no bound.", ratio=ratio))
    low, high = min(-1.0, *(float(each.min()) for each in lines)), max(1.0, *(float(each.max()) for each in lines))
    return PlaneFigure("gaps", text("a gap of k packets"), (
        Curve(text("growth of the variance"), lines[0], "error", "dash", 1.8, k),
        Curve(text("probability"), lines[1], "muted", "dash", 1.8, k),
        Curve(text("product"), lines[2], "plant", x=k),
        Curve(same("1"), np.zeros(2), "reference", "dot", 1.2, np.array([-0.5, LONGEST_GAP + 0.5]))),
        tuple(Point(float(at), float(value), "plant", "dot") for at, value in zip(k, lines[2], strict=True)), "k", text("factor"),
        (-0.5, LONGEST_GAP + 0.5), (1.1 * low, 1.1 * high), caption=said, tab=GAP_TAB, powers="y")
