"""Write the README of an exported design: ten lines on signs, units, rates and source."""

from __future__ import annotations

from ...devices import DeviceDesign
from .words import comment_word

__all__ = ["readme_text"]

C_USE = "`make test` runs the test; call `lab_init()` once, then `lab_step(y, u)` each period."


def readme_text(design: DeviceDesign, source: str, single: bool, use: str = C_USE) -> str:
    """Ten lines in English, each on one thing."""
    routine = design.routine
    gap = design.gap()
    loss = " ".join(each("en") for each in design.loss)
    lines = [
        "# A design of Observer Lab as code", "",
        f"- Source: {source}",
        f"- What it is: {routine.kind}, {len(routine.x_names)} states ({_words(routine.x_names)}), one step each {routine.period:.9g} s.",
        f"- Readings y, in SI units, NaN where one is missing: {_words(routine.y_names)}.",
        f"- Inputs u, in SI units: {_words(routine.u_names)}. "
        + ("The step computes them." if routine.drives else "Give what acts on the plant."),
        "- Signs: u = r - K xhat; xhat+ = A xhat + B u + L (y - C xhat - D u); e = x - xhat.",
        f"- Sampling: {routine.rule('en')}",
        f"- Cost of sampling: {loss or 'none, the design is sampled.'}",
        f"- Numbers: {'float, four bytes' if single else 'double, eight bytes'}; -ffp-contract=off and no fast-math, or the bits differ.",
        "- Test: a run of this design, replayed; every bit must be as in the lab's Python."
        + (f" The largest distance from the page's estimate is {gap:.2g} of its largest entry." if gap is not None else ""),
        f"- Use: {use}",
    ]
    return "\n".join(lines) + "\n"


def _words(names: tuple[str, ...]) -> str:
    return ", ".join(map(comment_word, names))
