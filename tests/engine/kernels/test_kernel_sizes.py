"""Kernels fit a screen and take few arguments: groups of them travel as named tuples."""

import ast
from pathlib import Path

from syntax import nodes

from observer_lab.engine import kernels

MAX_LINES, MAX_PARAMETERS = 60, 10
WHOLE = {  # not yet cut: a march whose modes travel as a named tuple takes twice as long
    "clipped.py march", "clipped.py careful", "limit_crossings.py piece"}


def test_no_kernel_is_longer_than_a_screen_or_takes_more_than_ten_arguments() -> None:
    large = set()
    for path in Path(kernels.__file__).parent.glob("*.py"):
        for node in nodes(path.read_text(encoding="utf-8")):
            if isinstance(node, ast.FunctionDef):
                taken = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                if len(taken) > MAX_PARAMETERS or (node.end_lineno or 0) - node.lineno >= MAX_LINES:
                    large.add(f"{path.name} {node.name}")
    assert large == WHOLE
