"""Example plants to try any lesson on: files in `assets/plants`, read as a stranger's file would be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from ..text.words import Text
from .own import Misfit, read

__all__ = ["EXAMPLES", "Example", "example"]

FOLDER = Path(__file__).parents[2] / "assets" / "plants"


@dataclass(frozen=True)
class Example:
    """A plant in a file, and what it is called."""

    file: str
    label: Text


EXAMPLES: Mapping[str, Example] = MappingProxyType({
    "aircraft": Example("aircraft.json", Text("Aircraft, lateral motion", "飞机横侧向运动")),
    "motor": Example("motor.json", Text("Motor with a flexible shaft", "柔性轴电机")),
    "tanks": Example("tanks.json", Text("Four tanks", "四容水箱")),
    "pendulum": Example("pendulum.json", Text("Inverted pendulum, sampled", "倒立摆（采样）")),
    "beam": Example("beam.mat", Text("Flexible beam, 16 states", "柔性梁（16 阶）")),
})


@lru_cache(maxsize=8)
def example(name: str) -> str:
    """The canonical text of an example plant. Raises Misfit naming those there are."""
    if name not in EXAMPLES:
        raise Misfit(Text(f"There is no example plant {name[:40]}; there are {', '.join(EXAMPLES)}.",
                          f"没有示例对象 {name[:40]}；现有：{'、'.join(EXAMPLES)}。"))
    file = EXAMPLES[name].file
    return read(file, (FOLDER / file).read_bytes())
