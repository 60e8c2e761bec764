"""Write cells as a Jupyter notebook."""

from __future__ import annotations

import json
from collections.abc import Iterable

__all__ = ["notebook_of"]


def notebook_of(cells: Iterable[tuple[str, str]]) -> str:
    """A notebook of ("markdown" or "code", source), nothing of it run yet."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": [_cell(kind, source, number) for number, (kind, source) in enumerate(cells)],
             "metadata": {"language_info": {"name": "python"}, "kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, ensure_ascii=False, indent=1)


def _cell(kind: str, source: str, number: int) -> dict[str, object]:
    code = {"outputs": [], "execution_count": None} if kind == "code" else {}
    return {"cell_type": kind, "id": f"part-{number}", "metadata": {}, "source": source, **code}
