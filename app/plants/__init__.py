"""List the named plants: `MODELS` by id, and `model(id)` with an error for unknown ids."""

from __future__ import annotations

from types import MappingProxyType

from ..engine import EngineError
from . import cart_pendulum, chip, spring_damper, two_mass
from .model import Model, Signal, Window
from .platform import model as platform

__all__ = ["MODELS", "Model", "Signal", "Window", "model"]

MODELS: MappingProxyType[str, Model] = MappingProxyType({m.id: m for m in (
    chip.MODEL, chip.RUNAWAY_MODEL, spring_damper.MODEL, cart_pendulum.MODEL, two_mass.MODEL,
    platform.DECK_MODEL, platform.PLATFORM_MODEL,
)})


def model(id: str) -> Model:
    """The model of that id. Raises EngineError, naming the ids there are."""
    try:
        return MODELS[id]
    except (KeyError, TypeError):
        raise EngineError("There is no plant {id}; choose one of {models}.", id=f'{id!r}', models=", ".join(MODELS)) from None
