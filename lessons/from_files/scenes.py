"""Read the path of a lesson file: scenes that set knobs, show figures and ask for one action."""

from __future__ import annotations

from collections.abc import Sequence

from observer_lab.course.knobs import Knob
from observer_lab.course.lesson import Task
from observer_lab.course.scenes import MAX_FIGURES, MAX_KNOBS, Choose, Do, Move, Press, Question, Read, Scene, Solve
from observer_lab.text import text

from .tasks import read_values
from .toml_table import Table

SCENE_KEYS = ("id", "do", "set", "play", "knobs", "figures", "task", "minutes", "core")
ACTIONS = ("read", "predict", "move", "play", "kick", "solve")


def read_path(top: Table, knobs: tuple[Knob, ...], figures: Sequence[str], tasks: Sequence[Task]) -> tuple[Scene, ...]:
    """`[[scenes]]`. Raises LessonFileError."""
    return tuple(_scene(table.only(*SCENE_KEYS), knobs, figures, tasks) for table in top.tables("scenes"))


def _scene(table: Table, knobs: tuple[Knob, ...], figures: Sequence[str], tasks: Sequence[Task]) -> Scene:
    shown, drawn = table.names("knobs", [knob.name for knob in knobs if not knob.hidden]), table.names("figures", figures)
    for key, names, most in (("knobs", shown, MAX_KNOBS), ("figures", drawn, MAX_FIGURES)):
        if len(names) > most:
            raise table.refuse(key, text("A scene shows at most {most} of the {key}; this one names {count}.", most=most, key=key,
                                         count=len(names)))
    minutes = table.number("minutes", 2.0)
    if minutes <= 0:
        raise table.refuse("minutes", text("minutes must be positive; it is {minutes:g}.", minutes=minutes))
    set, play = read_values(table, "set", knobs), read_values(table, "play", knobs)
    return Scene(table.words("id"), _action(table, shown, tasks), set, play, shown, drawn, minutes=minutes, core=table.switch("core", True))


def _action(table: Table, shown: tuple[str, ...], tasks: Sequence[Task]) -> Do:
    match table.one_of("do", ACTIONS, "read"):
        case "predict":
            return Choose(Question.FIRST)
        case "move":
            if not shown:
                raise table.refuse("do", text("A scene that asks to move a knob must name it in knobs."))
            return Move(shown)
        case "solve":
            return Solve(table.one_of("task", [task.id for task in tasks]))
        case "play" | "kick" as button:
            return Press(button)
        case _:
            return Read()
