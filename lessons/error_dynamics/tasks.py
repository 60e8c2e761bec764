"""The tasks of lesson 2 and its exam item."""

from __future__ import annotations

import numpy as np

from app.lesson.lesson import ExamItem, Outcome, Task, Verdict
from app.text.words import Text

from .knobs import NUMBERS, POLES, PRINTED, QUIET
from .notes import FIRST, GAIN, MATRIX, NONE, RIGHT_GAIN
from .study import Study


def _gain_words(outcome: Outcome[Study]) -> str:
    l1, l2 = outcome.gains["L"][:, 0]
    return f"({l1:.4g}, {l2:.4g})".replace("-", "−")


def double_pole(outcome: Outcome[Study]) -> Verdict:
    """Both observer poles at −1: λ² + 2λ + 1, compared by coefficients, which are exact where a double pole is not."""
    error = outcome.study.error
    damping, square = -float(np.trace(error)), float(np.linalg.det(error))
    words = _gain_words(outcome)
    if outcome.design["method"] == PRINTED:
        return Verdict(False, Text("This is the pair from the notes; choose the poles or the gain yourself.",
                                   "这是讲义所印的那一对；请自己选极点或增益。"))
    if abs(damping - 2) <= 0.02 and abs(square - 1) <= 0.02:
        return Verdict(True, Text(f"Both poles are at −1, and L = {words}.", f"两个极点都在 −1，L = {words}。"))
    return Verdict(False, Text(f"The polynomial is λ² + {damping:.3g}λ + {square:.3g}; it should be λ² + 2λ + 1.",
                               f"现在的多项式是 λ² + {damping:.3g}λ + {square:.3g}，应为 λ² + 2λ + 1。"))


def first_slip(outcome: Outcome[Study]) -> Verdict:
    """The line where the notes first go wrong, and the gain that follows once it is mended."""
    line, words = outcome.design["line"], _gain_words(outcome)
    if outcome.design["method"] == PRINTED or not np.allclose(outcome.gains["L"], RIGHT_GAIN, rtol=0, atol=1e-6):
        return Verdict(False, Text(f"The gain is {words}; find the one that puts both poles at −1 exactly.",
                                   f"现在的增益是 {words}；请找出使两个极点恰在 −1 的增益。"))
    if line == FIRST:
        return Verdict(True, Text(f"With L = {words} the sum of the poles asks l₁ + 0.5 = 2; the notes print l₁ − 0.5 = 2.",
                                  f"L = {words}；由极点之和得 l₁ + 0.5 = 2，讲义却印成 l₁ − 0.5 = 2。"))
    if line == NONE:
        return Verdict(False, Text(f"L = {words} is right. Now choose the first line of the notes that is wrong.",
                                   f"L = {words} 正确。再选出讲义中最先出错的一行。"))
    if line in (GAIN, MATRIX):
        return Verdict(False, Text("That line is wrong indeed, but it only inherits the slip from an earlier line.",
                                   "这一行确实不对，但错误是从前面某一行继承来的。"))
    return Verdict(False, Text("That line holds with the right gain; look at the others in the tab Notes.",
                               "代入正确的增益，这一行成立；请在“讲义”标签页里看其余各行。"))


def mixed_matrix(outcome: Outcome[Study]) -> Verdict:
    """The gain to which the printed matrix belongs: l₁ of the slip with the true l₂."""
    words = _gain_words(outcome)
    if outcome.design["method"] != PRINTED and np.allclose(outcome.gains["L"][:, 0], (2.5, -0.75), rtol=0, atol=1e-6):
        p = outcome.poles["observer"]
        reached = f"{p[0].real:.5f}, {p[1].real:.5f}".replace("-", "−")
        return Verdict(True, Text(f"L = {words}: l₁ from the slip, l₂ from the right gain. The poles are {reached}.",
                                  f"L = {words}：l₁ 来自笔误，l₂ 来自正确的增益。极点为 {reached}。"))
    return Verdict(False, Text(f"With L = {words} the matrix is not the printed one; compare the last row of the page, with "
                               "the gain typed by yourself.",
                               f"L = {words} 得到的矩阵与讲义所印不同；请自己输入增益，并对照该页最后一行。"))


def confused(outcome: Outcome[Study]) -> Verdict:
    """An input that moves the error: only possible if the matrix in the computer is not A − LC."""
    moved = outcome.metrics["error_moved"]
    if outcome.design["input"] == QUIET:
        return Verdict(False, Text("There is no input; choose one.", "现在没有输入，请选一种。"))
    left_alone = outcome.checks[0].holds  # an unstable observer may carry rounding far
    if moved >= 0.1 and not left_alone:
        return Verdict(True, Text(f"The input moves the error by up to {moved:.2g}: this pair is no observer of this plant.",
                                  f"输入使误差改变了 {moved:.2g}：这一对矩阵不是该对象的观测器。"))
    return Verdict(False, Text(f"The input moves the error by {moved:.0e}; look for a way to 0.1.",
                               f"输入对误差的影响只有 {moved:.0e}；请设法使它达到 0.1。"))


def exam(seed: int) -> ExamItem:
    """A block m = 1 with other b and k, both observer poles at −p: l₂ = p² − k − b l₁ with l₁ = 2p − b."""
    rng = np.random.default_rng(seed)
    b, k, p = float(rng.integers(1, 10)) / 10, float(rng.integers(1, 7)), float(rng.integers(2, 7))
    return ExamItem({"b": f"{b:g}", "k": f"{k:g}", "p": f"-{p:g}"}, p**2 - k - b * (2 * p - b), 0.005)


TASKS = (
    Task("double-pole", double_pole, {"method": POLES, "observer_poles": (-1.0, -1.0)}),
    Task("first-slip", first_slip, {"method": NUMBERS, "l1": 1.5, "l2": -0.75, "line": FIRST}),
    Task("mixed-matrix", mixed_matrix, {"method": NUMBERS, "l1": 2.5, "l2": -0.75, "line": "matrix"}),
    Task("confused", confused, {"method": PRINTED, "input": "step"}),
)
