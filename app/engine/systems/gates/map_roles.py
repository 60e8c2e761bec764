"""Call a map of the user's by what it takes: x, then u, t and dt where its parameters have them."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import EngineError
from ..records import record

__all__ = ["CLOCK_ROWS", "InTime", "NeedsTime", "adapted", "roles_of"]

CLOCK_ROWS = 2  # below the inputs of a map in time: t, then dt
_PLAIN = ("x", "u")


def roles_of(f: Any) -> tuple[str, ...]:
    """What each positional argument of a map is, of "x", "u", "t" and "dt": the first is x, then by name, then by place.

    One with a default is left alone unless it is called u, t or dt; what cannot be looked into takes x and u.
    """
    if isinstance(f, np.ufunc):
        return ("x",) if f.nin == 1 else _PLAIN
    try:
        parameters = list(inspect.signature(f).parameters.values())
    except (TypeError, ValueError):
        return _PLAIN
    if any(p.kind is p.VAR_POSITIONAL for p in parameters):
        return _PLAIN
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    roles: list[str] = []
    for place, p in enumerate(positional):
        if place and p.default is not p.empty and p.name not in ("u", "t", "dt"):
            break
        roles.append("x" if not place else p.name if p.name in ("u", "t", "dt") else ("u", "t", "dt")[min(place, 3) - 1])
    return tuple(roles) or _PLAIN


@record()
class _Alone:
    """f(x, u) of a map of x alone."""

    f: Callable[..., np.ndarray]

    def __call__(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self.f(x)


@record()
class NeedsTime:
    """A map that takes t or dt, before it is known when it is called."""

    f: Callable[..., Any]
    roles: tuple[str, ...]

    def __call__(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        raise EngineError("A map takes {roles}; give t to run, or t and dt to predict and t to correct.", roles=", ".join(self.roles))


@record()
class InTime:
    """A map of x and u, the time t and the step dt in the last two rows of u."""

    f: Callable[..., Any]
    roles: tuple[str, ...] = _PLAIN

    def __call__(self, x: np.ndarray, u: np.ndarray) -> Any:
        given = {"x": x, "u": u[:-CLOCK_ROWS], "t": float(u[-2, 0]), "dt": float(u[-1, 0])}
        return self.f(*(given[role] for role in self.roles))


def adapted(f: Any) -> Any:
    """A map as the engine calls it, f(x, u): itself, of x alone, or one that needs the time."""
    roles = roles_of(f)
    if roles == _PLAIN:
        return f
    return _Alone(f) if roles == ("x",) else NeedsTime(f, roles)
