"""Write a design as plain Python for MicroPython: the step as it stands, its tables, a test."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Mapping

import numpy as np

from ...devices import DeviceDesign, Routine, Table
from .words import header_line, readme_text, template

__all__ = ["micropython_folder", "python_module"]

TESTED = 100  # samples that the test replays on a small board
MICROPYTHON_USE = ("copy lab.py and main.py to the board, set pins and scales at the head of main.py. A board whose floats have four bytes "
                   "rounds as `--to c --float` does.")


def micropython_folder(design: DeviceDesign, source: str, single: bool = False) -> Mapping[str, str]:
    """lab.py, its test, and a main.py that samples, steps and prints the lines of `live`."""
    routine = design.routine
    p, m = len(routine.y_names), len(routine.u_names)
    main = template("main.py", "micropython").format(header=header_line(routine), micros=round(routine.period * 1e6), p=p, m=m,
                                                     pins=", ".join(str(26 + k) for k in range(p)), scales=", ".join(["1.0"] * p),
                                                     offsets=", ".join(["0.0"] * p))
    found = design.expected()
    count = min(len(design.y), TESTED)
    rows = {"y": design.y, "u": design.u, **({"r": design.r} if design.r is not None else {})}
    given = "\n".join(f"{name} = {_rows(values[:count])}" for name, values in rows.items())
    page = "\n".join(f"page_{name} = {_rows(values[:count])}" for name, values in found.items())
    checks = "\n".join(f"    wrong += differ(lab.{name}, page_{name}[k])" for name in found)
    test = template("lab_test.py", "micropython").format(given=given, page=page, checks=checks, count=count,
                                                         command="    lab.r[:] = r[k]\n" if design.r is not None else "")
    return {"lab.py": python_module(routine), "lab_test.py": test, "main.py": main,
            "README.md": readme_text(design, source, single, MICROPYTHON_USE)}


def python_module(routine: Routine) -> str:
    """The tables and the step as a module that needs `math` alone."""
    tables = "\n".join(_table(each) for each in (*routine.constants, *routine.states))
    room = "\n".join(f"{name} = [0.0] * {length}" for name, length in {**routine.scratch, "y": len(routine.y_names),
                                                                          "u": len(routine.u_names)}.items())
    sizes = "\n".join(f"{name} = {value}" for name, value in routine.sizes.items())
    helpers, body = _split(routine.source)
    return template("lab.py", "micropython").format(period=repr(routine.period), sizes=sizes, tables=tables, room=room, helpers=helpers,
                                                    body=textwrap.indent(body, "    "), drives=routine.drives)


def _split(source: str) -> tuple[str, str]:
    """The helper functions of a step, and its statements."""


    tree = ast.parse(source)
    parts = {True: [], False: []}
    for node in tree.body:
        parts[isinstance(node, ast.FunctionDef)].append(ast.get_source_segment(source, node) or "")
    return "\n\n".join(parts[True]), "\n".join(parts[False])


def _table(each: Table) -> str:
    return (f"# {each.note}\n" if each.note else "") + f"{each.name} = [{', '.join(map(_number, each.values))}]"


def _number(value: float) -> str:
    value = float(value)
    return repr(value) if np.isfinite(value) else f"float('{value}')"


def _rows(values: np.ndarray) -> str:
    return "[" + ",\n     ".join("[" + ", ".join(map(_number, row)) + "]" for row in values.tolist()) + "]"
