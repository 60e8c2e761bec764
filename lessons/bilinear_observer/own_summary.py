"""Say which conditions hold for an own bilinear plant, or which one fails and what to change."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from observer_lab.course.figures.claims import claim
from observer_lab.course.lesson import Design
from observer_lab.engine.observers import BilinearObserver
from observer_lab.text import Text, text

from ..toolkit.boards import listed
from ..toolkit.latex import pole_words
from .own_plant import Wanted
from .study import LAW_TOLERANCE, bound, counts


def live(design: Design, wanted: Wanted, found: np.ndarray, m: Mapping[str, float]) -> Text:
    """The sentence of the present design: what holds, or which condition fails and what to change."""
    o, late = wanted.solved, m["late_error"]
    if o.case == 1:
        return _no_gain(o, late)
    fixed = tuple(map(complex, found)) if o.case == 2 else wanted.bolted
    right = [p for p in fixed if p.real >= 0]
    if right and o.case == 2:
        return text("Case 2: one L only, and its pole {poles} is not on the left, so ε does not decay. Measure more, or want another "
                    "g.", poles=pole_words(right))
    if right:
        return text("Case 3: a family of L, but the pole {poles} stays put in all of them, so ε does not decay. Measure other "
                    "states, or want another g.", poles=pole_words(right))
    if m["slowest"] >= 0:
        return text("An observer pole is not on the left, so ε does not decay: drag it left.")
    if design["noise"]:
        return claim(text("The sensors' noise moves ĝ by {rms:.2g} of g (rms, second half of the run); at rest and u = 0 its law says "
                          "{promised:.2g}.", rms=m["noise_rms"], promised=m["noise_promised"]), m["noise_rms"], above=0.0)
    poles = pole_words(listed(found)[:6])
    follows = text("Case {case}: an observer of order {order} estimates g, and ε decays under this u; poles: {poles}.",
                   case=o.case, order=o.order, poles=poles)
    return claim(follows, m["law_gap"], below=LAW_TOLERANCE, otherwise=text(
        "The poles are {poles}, but something still drives ε: when the run ends it is {late:.2g} of g.", poles=poles, late=late))


def _no_gain(o: BilinearObserver, late: float) -> Text:
    (have, need), (left, right) = counts(o), bound(o.plant).split("≥")
    if o.advised:
        return text("Case 1: (21) fails, and the nearest L leaves ε at {late:.2g} of g when the run ends. Measure other states, or want "
                    "another g.", late=late)
    return text("Case 1: (21) fails, and the nearest L leaves ε at {late:.2g} of g when the run ends. {left} is {have}, {right} is {need}: "
                "measure more, or want another g.", late=late, left=left.strip(), have=have, right=right.strip(), need=need)
