"""Write the line above a lesson that says whose plant it shows."""

from __future__ import annotations

from ..plants.model import Model
from ..text import Text, error_words, joined, text

__all__ = ["write_banner"]


def write_banner(model: Model, universal: bool, bilinear: bool, sampled: bool) -> Text:
    """What is shown, what the text means, and what of the plant is left out."""
    p = model.plant
    name = text("“{name}”", name=model.label) if p.name else model.label
    shown = text("**This page shows {name}** (states {n}, inputs {m}, outputs {p}).",
                 name=name, n=p.n, m=p.m, p=p.p)
    shown = joined(shown, *map(error_words, p.notes))
    if model.beyond.F is not None and not bilinear:
        shown = joined(shown, text("Its bilinear term u F x is left out here: this is the plant linearised at x = 0 and u = 0."))
    if model.beyond.F is None and bilinear:
        shown = joined(shown, text("Its file has no bilinear term: F is zero here, and the first input is u."))
    if universal:
        return shown
    others = text("Text, prediction and exams speak of the lesson's own plant.")
    hold = text("It came sampled; here it is the continuous plant that a held input turns into those samples.")
    return joined(shown, others, hold) if sampled else joined(shown, others)
