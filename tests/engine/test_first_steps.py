"""The notebook for newcomers runs from its first cell to its last, and what its cells say comes out."""

from __future__ import annotations

import ast
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "assets" / "notebooks" / "first_steps.ipynb"


def cells() -> list[str]:
    return ["".join(cell["source"]) for cell in json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]


def played(source: str, names: dict[str, Any]) -> Any:
    """Run a cell as a notebook does; the value of a last expression is what it shows."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return None if last is None else eval(compile(ast.Expression(last.value), "cell", "eval"), names)


def test_first_steps_run_and_say_what_is_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "Agg")
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    names: dict[str, Any] = {}
    shown = [played(source, names) for source in cells()]
    pyplot.close("all")
    assert len(shown) == 11
    assert all(len(repr(value)) < 400 for value in shown)
    assert shown[2] == (True, True)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(shown[3]).real), [-7, -6])
    both = np.concatenate([names["E"], [-6, -7]])
    np.testing.assert_allclose(np.sort_complex(shown[4]), np.sort_complex(both), atol=1e-8)
    np.testing.assert_allclose(np.sort_complex(shown[7][0]), np.sort_complex(np.roots([1, 0.3, 2.5])))  # of the loop by python-control
    filtered, smoothed = names["rms"]
    assert smoothed < filtered < 1.0
