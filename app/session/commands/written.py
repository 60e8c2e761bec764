"""Write what a hand has done on one page of a presenter, for those at other workers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from numbers import Complex, Integral, Real
from types import MappingProxyType
from typing import Any  # a value of JSON is of any kind, as `Any` says

import msgspec

from ...course.knobs import ByHand
from . import commands, guide, room
from .commands import Edit, Play, SetKnobs

MIRRORED = (SetKnobs, commands.DrawByHand, Play, commands.Kick, commands.Rewind, commands.Seek, commands.ChangeSpeed, commands.Undo,
            commands.Redo, commands.Reset, commands.ChoosePlant, commands.PickPoint, commands.Predict, commands.PredictAgain,
            commands.ShowAgain, commands.ShowSolution, commands.Reveal, commands.OpenLesson, commands.TurnPage, guide.SetMode,
            guide.GoToScene, guide.TurnedTo, guide.ChooseOption, guide.AnswerByHand, guide.RestartScene, guide.ShowKeptRun,
            guide.OpenLecture, guide.EndLecture, room.PerformAnswer)
_KINDS = MappingProxyType({kind.__name__: kind for kind in MIRRORED})


def write_edit(edit: Edit) -> str:
    """An edit of a kind that is mirrored, as JSON. Raises TypeError at a value that has no written form."""
    return json.dumps([type(edit).__name__, {name: _written(value) for name, value in msgspec.structs.asdict(edit).items()}])


def read_edit(words: str) -> Edit:
    """The edit in such words. Raises ValueError."""
    try:
        kind, fields = json.loads(words)
        return _KINDS[kind](**{str(name): _read(value) for name, value in fields.items()})
    except (TypeError, KeyError, IndexError, AttributeError, RecursionError) as problem:
        raise ValueError("these words are no edit") from problem


def _written(value: object) -> object:
    """A value as JSON has it; what JSON lacks is an object of one name."""
    match value:
        case None | bool() | str():
            return value
        case bytes():
            return {"bytes": value.decode("latin-1")}
        case ByHand():
            return {"hand": [value.force, value.released]}
        case Mapping():
            return {"mapping": [[str(name), _written(each)] for name, each in value.items()]}
        case list() | tuple():
            return {"tuple" if isinstance(value, tuple) else "list": [_written(each) for each in value]}
        case Integral():
            return int(value)
        case Real():
            return float(value)
        case Complex():
            return {"complex": [float(value.real), float(value.imag)]}
    raise TypeError(f"a {type(value).__name__} has no written form")


def _read(value: Any) -> object:
    if not isinstance(value, dict):
        return value
    (kind, parts), = value.items()
    match kind:
        case "bytes":
            return str(parts).encode("latin-1")
        case "hand":
            return ByHand(float(parts[0]), bool(parts[1]))
        case "mapping":
            return {str(name): _read(each) for name, each in parts}
        case "tuple":
            return tuple(_read(each) for each in parts)
        case "list":
            return [_read(each) for each in parts]
        case "complex":
            return complex(float(parts[0]), float(parts[1]))
    raise ValueError(f"{str(kind)[:20]} is no kind of value")
