"""Keep what stands on a page that nobody looks at, value by value."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .shared_page import REPEATED, SharedPage, script_name

UUID = re.compile(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}")
NODE = re.compile(r'"node": ("[^"]*")')  # what a script that is called for one node is told
ONCE = frozenset({"ResetGuiMessage", "play"})  # what somebody who comes later needs nothing of
Place = tuple[str, str]  # an entity, "gui:w3" or "scene:/plant/deck", and one of its properties; "" is how it was made


class PageTape(SharedPage):
    """What `viser.ClientHandle` is for a browser, where nobody looks: `values` has all that stands, by place.

    Widgets are named by the order in which they were made, so that two recordings of one page are alike.
    """

    def __init__(self, width: int, height: int) -> None:
        self.values: dict[Place, Any] = {}
        self._widgets: dict[str, str] = {}
        super().__init__(width, height, lambda _: None)

    def push(self, message: Any) -> None:
        """Write down what a message changes."""
        arrays: list[memoryview] = []
        told = self.plain(message.as_serializable_dict(arrays), arrays)
        if "run_id" in told:
            told["run_id"] = "tape"
        kind, phase = message.entity_type, message.lifecycle_phase
        if kind is None:
            self._note(script_name(message), message, told)
            return
        entity = f"{kind}:{told[message.entity_id_field]}"
        if phase == "remove":
            self._forget_entity(entity, kind == "scene")
        elif phase == "create":
            self._forget_entity(entity, False)
            props = told.pop("props", {})
            self.values[entity, ""] = told
            if "value" in told:  # as nobody has moved it yet
                self.values[entity, "value"] = told["value"]
            self.values.update({(entity, name): value for name, value in props.items()})
        elif phase == "update_dict":
            self.values.update({(entity, name): value for name, value in told["updates"].items()})
        else:
            self.values[entity, f"@{told['type']}"] = told

    def _note(self, script: str, message: Any, told: dict[str, Any]) -> None:
        """Write down a message about no widget and no node, or about a node that it does not make."""
        about, prop = script or message.redundancy_key(), ""
        node = NODE.search(told["source"]) if script in REPEATED else None
        if node is not None or told["type"].startswith("SetSceneNode"):
            about, prop = f"scene:{told['name'] if node is None else json.loads(node[1])}", f"@{script or told['type']}"
        if script in ONCE or told["type"] in ONCE:
            return
        self.values.pop((about, prop), None)
        self.values[about, prop] = told

    def remove_entity_state_from_buffer(self, kind: str, name: str) -> None:
        """Another node takes the place of one with this name: nothing that was said of the old one is true of it."""
        self._forget_entity(f"{kind}:{name}", False)

    def flush(self) -> None:
        """Nobody waits for anything."""

    def _forget_entity(self, entity: str, below: bool) -> None:
        start = entity + "/"
        for place in [place for place in self.values if place[0] == entity or (below and place[0].startswith(start))]:
            del self.values[place]

    def plain(self, value: Any, arrays: Sequence[memoryview] = ()) -> Any:
        """A value with arrays of its own and with widgets under their short names."""
        if isinstance(value, str):
            return UUID.sub(self._short, value) if len(value) >= 36 else value
        if isinstance(value, dict):
            if "__binary_index" in value:
                return np.frombuffer(arrays[value["__binary_index"]], dtype=value["dtype"]).copy()
            return {key: self.plain(each, arrays) for key, each in value.items()}
        if isinstance(value, (list, tuple)):
            return [self.plain(each, arrays) for each in value]
        return value

    @property
    def _short(self) -> Callable[[re.Match[str]], str]:
        return lambda found: self._widgets.setdefault(found[0], f"w{len(self._widgets) + 1}")
