"""Frozen records with a repr of at most 200 characters, and tables for a notebook."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass
from html import escape
from typing import Any, TypeVar, dataclass_transform

import numpy as np

__all__ = ["record", "short"]

T = TypeVar("T")
MAX_CHARACTERS, MAX_WORD = 200, 40
MAX_SIDE = 8  # rows and columns of a matrix that a notebook shows whole


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def record(*, eq: bool = False) -> Callable[[type[T]], type[T]]:
    """A frozen dataclass whose repr shows arrays by their shape, and which a notebook shows as a table.

    Two records are equal where they are the same one, or field by field with `eq`.
    """
    def make(kind: type[T]) -> type[T]:
        made = dataclass(frozen=True, eq=eq, repr=False)(kind)
        if "__repr__" not in vars(kind):
            made.__repr__ = _repr  # type: ignore[method-assign]
        if not hasattr(kind, "_repr_html_"):
            made._repr_html_ = _html  # type: ignore[attr-defined]
        return made
    return make


def short(value: object) -> str:
    """A value in a few characters: an array by its shape, a record by its kind, a list by its length."""
    if isinstance(value, np.ndarray):
        return "×".join(map(str, value.shape)) if value.ndim else f"{value.item():.6g}"
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}(…)"
    if isinstance(value, tuple | list | dict | frozenset) and len(value) > 3:
        return f"({len(value)} entries)"
    if isinstance(value, tuple | list):
        return "(" + ", ".join(map(short, value)) + ("," if len(value) == 1 else "") + ")"
    if isinstance(value, bool | np.bool_ | int | np.integer) or value is None:
        return str(value)[:MAX_WORD]
    if isinstance(value, float | complex | np.number):
        return f"{value:.6g}"
    if callable(value) and hasattr(value, "__name__"):
        return str(value.__name__)
    text = repr(value)
    return text if len(text) <= MAX_WORD else f"{text[:MAX_WORD - 1]}…"


def _shown(value: Any) -> list[tuple[str, object]]:
    """The fields to be shown; a default that was not changed is left out."""
    return [(f.name, getattr(value, f.name)) for f in fields(value) if f.repr and not _is_default(getattr(value, f.name), f.default)]


def _is_default(value: object, default: object) -> bool:
    return value is default or (isinstance(default, bool | int | float | str | tuple) and type(value) is type(default) and value == default)


def _repr(self: Any) -> str:
    text = f"{type(self).__name__}({', '.join(f'{name}={short(value)}' for name, value in _shown(self))})"
    return text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS - 2]}…)"


def _html(self: Any) -> str:
    """A table of the fields for a notebook: small matrices whole, poles, the rest in a few characters."""
    rows = _shown(self)
    if isinstance(getattr(type(self), "poles", None), property) or hasattr(type(self).__dict__.get("poles"), "func"):
        rows.append(("poles", self.poles))
    lines = "".join(f"<tr><th style='text-align:left'>{escape(name)}</th><td style='text-align:left'>{_cell(value)}</td></tr>"
                    for name, value in rows)
    return f"<table><caption>{escape(type(self).__name__)}</caption>{lines}</table>"


def _cell(value: object) -> str:
    if not isinstance(value, np.ndarray) or value.ndim not in (1, 2) or max(value.shape, default=0) > MAX_SIDE or not value.size:
        return escape(short(value))
    if value.ndim == 1:
        return ", ".join(map(_number, value))
    return "<table>" + "".join("<tr>" + "".join(f"<td>{_number(v)}</td>" for v in row) + "</tr>" for row in value) + "</table>"


def _number(value: Any) -> str:
    if not isinstance(value, float | complex | np.floating | np.complexfloating):
        return escape(str(value))
    if isinstance(value, complex) and not value.imag:
        value = value.real
    return f"{value:.4g}".replace("-", "−")
