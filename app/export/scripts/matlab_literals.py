"""Write numbers and formulas in MATLAB, and collect the library functions that a file needs."""

from __future__ import annotations

import re

import numpy as np

from .literals import template_text

__all__ = ["array", "body_of", "complex_row", "formula", "functions_for", "number"]

IN_MATLAB = ((r"\['(\w+)'\]", r".\1"), (r"\beigvals\(", "eig("), (r"\bnp\.roots\(", "roots("), (r"\blen\(", "numel("), (r"@", "*"))
LOCAL = "%% Functions\n"


def number(value: float) -> str:
    """A number that reads back exactly."""
    return repr(float(value)) if np.isfinite(value) else "NaN" if np.isnan(value) else "Inf" if value > 0 else "-Inf"


def array(name: str, value: object, note: str = "") -> str:
    """An assignment that reads back exactly: a list as a row, a row of a matrix a line."""
    rows = np.asarray(value, dtype=float)
    tail = f"  % {note}" if note else ""
    if not rows.size:
        return f"{name} = zeros({rows.shape[0]}, {rows.shape[-1] if rows.ndim > 1 else 1});{tail}"
    if rows.ndim < 2:
        return f"{name} = [{' '.join(map(number, rows.ravel().tolist()))}];{tail}"
    lines = ("; ...\n" + " " * (len(name) + 4)).join(" ".join(map(number, row)) for row in rows.tolist())
    return (f"% {note}\n" if note else "") + f"{name} = [{lines}];"


def complex_row(poles: np.ndarray) -> str:
    """A set of poles."""
    return "[" + ", ".join(f"complex({float(p.real)!r}, {float(p.imag)!r})" for p in np.asarray(poles, dtype=complex)) + "]"


def formula(python: str) -> str:
    """The name of a result, or a short formula of names, from Python: eigvals(A - B @ K) is eig(A - B * K)."""
    for pattern, instead in IN_MATLAB:
        python = re.sub(pattern, instead, python)
    return python


def body_of(name: str) -> tuple[str, str]:
    """The equations of a part, and the functions of its own that stand behind them."""
    body, _, local = template_text(f"matlab_{name}").partition(LOCAL)
    return body.rstrip(), local.rstrip()


def functions_for(text: str) -> str:
    """The functions of our library that a text calls, and those that they call, in the library's order."""
    library = {block.split("(", 1)[0].split()[-1]: block.rstrip()
               for part in ("proof", "library") for block in re.split(r"\n(?=function )", template_text(f"matlab_{part}"))}
    needed: set[str] = set()
    waiting = [text]
    while waiting:
        called = {name for name in library if re.search(rf"\b{name}\(", waiting[-1])} - needed
        waiting.pop()
        needed |= called
        waiting += [library[name].split("\n", 1)[1] for name in called]
    return "\n\n".join(block for name, block in library.items() if name in needed)
