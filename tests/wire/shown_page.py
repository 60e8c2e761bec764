"""What stage and charts of a page show after the messages that came, as viser's page reads them."""

from __future__ import annotations

from typing import Any

import numpy as np

POSES = {"SetPositionMessage": "position", "SetOrientationMessage": "wxyz", "SetSceneNodeVisibilityMessage": "visible"}
START = {"position": (0.0, 0.0, 0.0), "wxyz": (1.0, 0.0, 0.0, 0.0), "visible": True}


class ShownPage:
    """Nodes with their place and properties, and the curves of charts.

    As in viser's page a node that replaces one of the same name keeps its place, and one that was removed does not.
    """

    def __init__(self) -> None:
        self.nodes: dict[str, dict[str, Any]] = {}
        self.charts: dict[str, dict[str, Any]] = {}

    def take(self, message: dict[str, Any], arrays: list[bytes]) -> None:
        """Do what a message from the server says."""
        kind, name = message["type"], message.get("name", "")
        if kind in POSES and name in self.nodes:
            self.nodes[name][POSES[kind]] = message[POSES[kind]]
        elif kind == "SceneNodeUpdateMessage" and name in self.nodes:
            self.nodes[name]["props"] |= _read(message["updates"], arrays)
        elif kind == "RemoveSceneNodeMessage":
            self.nodes.pop(name, None)
        elif "props" in message and name.startswith("/"):
            place = {key: self.nodes.get(name, START)[key] for key in START}
            self.nodes[name] = {**place, "kind": kind, "props": _read(message["props"], arrays)}
        elif kind == "GuiUplotMessage":
            self.charts[message["uuid"]] = _read(message["props"], arrays)
        elif kind == "GuiUpdateMessage" and message["uuid"] in self.charts:
            self.charts[message["uuid"]] |= _read(message["updates"], arrays)
        elif kind == "GuiRemoveMessage":
            self.charts.pop(message["uuid"], None)

    def in_sight(self) -> dict[str, dict[str, Any]]:
        """The nodes that are visible, as all that they lie under are."""
        return {name: node for name, node in self.nodes.items() if all(
            self.nodes.get(above, START)["visible"] for above in _lineage(name))}


def _lineage(name: str) -> list[str]:
    parts = name.split("/")
    return ["/".join(parts[:k]) for k in range(2, len(parts) + 1)]


def _read(value: Any, arrays: list[bytes]) -> Any:
    """A value with the arrays in it; an array that is nowhere finite where another is equals it there."""
    match value:
        case {"__binary_index": int(k), "dtype": str(kind)}:
            return np.frombuffer(arrays[k], kind)
        case dict():
            return {key: _read(part, arrays) for key, part in value.items()}
        case list() | tuple():
            return [_read(part, arrays) for part in value]
    return value


def differences(one: Any, other: Any, tolerance: float, where: str = "") -> list[str]:
    """Where two values differ by more than the tolerance."""
    if isinstance(one, dict) and isinstance(other, dict):
        return [line for key in sorted({*one, *other}) for line in differences(one.get(key), other.get(key), tolerance, f"{where}.{key}")]
    if isinstance(one, np.ndarray | list | tuple) and isinstance(other, np.ndarray | list | tuple):
        if len(one) != len(other):
            return [f"{where}: {len(one)} and {len(other)} values"]
        if all(isinstance(part, int | float | np.number) for part in (*one, *other)):
            a, b = np.asarray(one, float), np.asarray(other, float)
            return [] if np.allclose(a, b, rtol=tolerance, atol=tolerance, equal_nan=True) else [f"{where}: {a[:4]} and {b[:4]}"]
        return [line for k, (a, b) in enumerate(zip(one, other, strict=True)) for line in differences(a, b, tolerance, f"{where}[{k}]")]
    if isinstance(one, int | float) and isinstance(other, int | float):
        return [] if abs(one - other) <= tolerance * (1 + abs(one)) else [f"{where}: {one} and {other}"]
    return [] if one == other else [f"{where}: {str(one)[:60]!r} and {str(other)[:60]!r}"]
