"""What the signals of a plant are called. A file speaks one language; the examples of the lab are known in both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..engine import Plant
from ..text.words import Text, same

__all__ = ["TITLES", "Title", "called", "title_of", "with_unit"]

UNNAMED = Text("your plant", "你的对象")


@dataclass(frozen=True)
class Title:
    """A plant's name in Chinese, and those of its signals by their names in the file."""

    zh: str
    signals: Mapping[str, str]


TITLES: Mapping[str, Title] = MappingProxyType({
    "Aircraft, lateral motion": Title("飞机横侧向运动", MappingProxyType({
        "sideslip": "侧滑角", "roll rate": "滚转角速度", "yaw rate": "偏航角速度", "bank": "倾斜角", "aileron": "副翼",
        "rudder": "方向舵", "yaw gyro": "偏航陀螺", "bank angle": "倾角计"})),
    "Motor with a flexible shaft": Title("柔性轴电机", MappingProxyType({
        "current": "电流", "motor speed": "电机转速", "twist": "扭转角", "load speed": "负载转速", "voltage": "电压",
        "tachometer": "测速计"})),
    "Four tanks": Title("四容水箱", MappingProxyType({
        **{f"level {i}": f"液位 {i}" for i in (1, 2, 3, 4)}, "pump 1": "泵 1", "pump 2": "泵 2", "gauge 1": "液位计 1",
        "gauge 2": "液位计 2"})),
    "Inverted pendulum, sampled": Title("倒立摆（采样）", MappingProxyType({
        "cart": "小车位置", "angle": "摆角", "cart speed": "小车速度", "turn rate": "摆角速度", "force": "力",
        "cart place": "位置传感器", "lean": "倾角传感器"})),
    "Flexible beam": Title("柔性梁", MappingProxyType({"force": "力", "middle": "中部传感器", "end": "端部传感器"})),
})


def title_of(plant: Plant) -> Text:
    """What the plant is called."""
    known = TITLES.get(plant.name)
    return UNNAMED if not plant.name else same(plant.name) if known is None else Text(plant.name, known.zh)


def called(plant: Plant, name: str) -> Text:
    """What a signal of the plant is called: as in its file, in Chinese too where the plant is an example."""
    known = TITLES.get(plant.name)
    return same(name) if known is None else Text(name, known.signals.get(name, name))


def with_unit(plant: Plant, name: str) -> Text:
    """The same with its unit in brackets, for an axis or a table."""
    unit = plant.unit(name)
    return Text("{} [{}]", "{} [{}]").format(called(plant, name), unit) if unit else called(plant, name)
