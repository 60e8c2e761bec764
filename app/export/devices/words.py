"""Write the words of generated code: templates, safe names, the header of its lines, its README."""

from __future__ import annotations

import re
from pathlib import Path

from ...devices import DeviceDesign, Routine

__all__ = ["column_names", "comment_word", "header_line", "identifier", "readme_text", "template"]

TEMPLATES = Path(__file__).parents[1] / "templates" / "devices"
LONGEST_WORD = 60  # characters of a name in a comment
C_USE = "`make test` runs the test; call `lab_init()` once, then `lab_step(y, u)` each period."


def template(name: str, body: str = "c") -> str:
    """A file of a body's folder as it stands."""
    return (TEMPLATES / body / f"{name}.txt").read_text(encoding="utf-8")


def comment_word(word: str) -> str:
    """A signal's name as it may stand in a comment: letters, digits, blanks and a few signs, so that no name ends the comment."""
    return re.sub(r"[^\w \[\]().,^+-]", "_", word, flags=re.ASCII)[:LONGEST_WORD].strip() or "unnamed"


def identifier(word: str, taken: set[str]) -> str:
    """A name that every language here accepts, and that is not taken yet; it is added to `taken`."""
    plain = re.sub(r"\W+", "_", word, flags=re.ASCII).strip("_")[:30] or "signal"
    plain = f"s_{plain}" if plain[0].isdigit() else plain
    name, count = plain, 1
    while name.lower() in taken:
        count += 1
        name = f"{plain}_{count}"
    taken.add(name.lower())
    return name


def column_names(routine: Routine) -> list[str]:
    """The columns of a line: the time, every input, every reading."""
    taken: set[str] = set()
    inputs, readings = ([identifier(name, taken) for name in names] for names in (routine.u_names, routine.y_names))
    return ["t", *(f"u:{name}" for name in inputs), *(f"y:{name}" for name in readings)]


def header_line(routine: Routine) -> str:
    """The comment line that names the columns, as in `# t,u:force,y:angle`."""
    return "# " + ",".join(column_names(routine))


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
