"""Test four claims about observability, one of them from the notes and wrong."""

from __future__ import annotations

from dataclasses import dataclass

from observer_lab.text import Text, format_number, same, text

from .cases import Sensed

DET, GRAMIAN, RANK_CRITERION, PBH = "det", "gramian", "rank", "pbh"
CRITERIA = (
    (DET, text("det(C e^{At}) ≠ 0 at every t")),
    (RANK_CRITERION, text("rank(O) = n")),
    (GRAMIAN, same("∫ e^{Aᵀt}CᵀC e^{At} dt > 0")),
    (PBH, text("rank [A − λI; C] = n at every λ")),
)


@dataclass(frozen=True)
class Criterion:
    """One sentence with the number it rests on and what it says of the present plant; None: it says nothing."""

    id: str
    text: Text
    number: str
    says: bool | None


def criteria(s: Sensed, rank: int) -> tuple[Criterion, ...]:
    """What each sentence says; rank(O) as counted at the tolerance, the Gramian over the run.

    A Gramian with an eigenvalue below rounding cannot tell zero from small; it is taken for zero where a mode is hidden.

    Source of the wrong one: observer notes (001), section 2.3, item 2. C e^{At} is p×n: for p < n its rank is below n
    at every t, and it has no determinant.
    """
    n, p = s.plant.n, s.plant.p
    least = float(s.heard[-1, 0])
    weakest = min((m.distance for m in s.seen.modes), default=0.0)
    numbers = {
        DET: (f"{p}×{n}", None),
        RANK_CRITERION: (f"{rank}/{n}", rank == n),
        GRAMIAN: (f"λ_min = {format_number(least, '.2g')}", True) if least > s.dust else (
            f"λ_min < {format_number(s.dust, '.0e')}", None if s.seen.observable else False),
        PBH: (f"σ_min = {format_number(weakest, '.2g')}" if s.seen.observable else "σ_min ≈ 0", s.seen.observable),
    }
    return tuple(Criterion(name, text, *numbers[name]) for name, text in CRITERIA)
