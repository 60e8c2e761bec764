"""Write the matrices of a routine as a MATLAB script for Simulink's blocks."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ...devices import DeviceDesign, Table
from .words import comment_word, readme_text

__all__ = ["simulink_folder"]

SIMULINK_USE = "run lab_blocks.m, then put the named matrices into the blocks that it lists, with sample time Ts."
BLOCKS = MappingProxyType({
    "observer": ("Ao = A - L*C;  Bo = [B, L];", "Discrete State-Space: A = Ao, B = Bo, C = eye(size(A)), "
                 "D = zeros(size(Bo)), inputs [u; y]"),
    "controller": ("", "Discrete State-Space: A = F, B = L, C = -N, D = -M, input y, output u"),
})


def simulink_folder(design: DeviceDesign, source: str, single: bool = False) -> Mapping[str, str]:
    """lab_blocks.m with every table of the routine under its name, and its README."""
    routine = design.routine
    code, block = BLOCKS.get(routine.kind, ("", "MATLAB Function block with the equations in the comments above, one step each Ts"))
    names = [f"% {name}({k + 1}): {comment_word(word)}" for name, words in (
        ("y", routine.y_names), ("u", routine.u_names), ("xhat", routine.x_names)) for k, word in enumerate(words)]
    lines = [f"% Written by Observer Lab: {routine.kind}. SI units.", *names, f"Ts = {routine.period!r};",
             *(_matrix(each) for each in routine.constants), *(_matrix(each, "_start") for each in routine.states),
             *([code] if code else []), f"% {block}"]
    return {"lab_blocks.m": "\n".join(lines) + "\n", "README.md": readme_text(design, source, single, SIMULINK_USE)}


def _matrix(each: Table, end: str = "") -> str:
    rows, columns = each.shape
    values = [repr(v).replace("inf", "Inf").replace("nan", "NaN") for v in each.values]
    body = "; ".join(", ".join(values[k * columns:(k + 1) * columns]) for k in range(rows))
    return (f"% {each.note}\n" if each.note else "") + f"{each.name}{end} = [{body}];"
