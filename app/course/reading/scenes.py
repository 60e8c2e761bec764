"""Read the scenes of a path: what each sets and shows, and the one action that it asks for."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import cast, get_args

from ...text import text
from ..knobs import Knob
from ..scenes import MAX_FIGURES, MAX_KNOBS, Camera, Choose, Do, Goal, Move, Press, Question, Read, Scene, SceneWords, Solve, Way
from .toml_table import Table, check_value, knob_named, read_table, read_values

ACTION_KEYS = MappingProxyType({"answer": "choose", "move": "move", "goal": "move", "task": "solve"})  # which action each belongs to
SCENE_KEYS = ("id", "do", *ACTION_KEYS, "set", "play", "knobs", "figures", "boards", "formulas", "lines", "camera",
              "moment", "told", "runs", "minutes", "core")
ACTIONS = ("read", "predict", "again", "choose", "move", "play", "kick", "pull", "solve")
HEADING, BEGIN, END = re.compile(r"## ([\w-]+):"), "```toml", "```"


def scenes_of(file: str, words: str) -> Table:
    """The tables `[[scenes]]` of a Markdown file: below each heading `## id: title` a block of TOML, whose lines keep their numbers.

    Raises LessonFileError where a block is no TOML.
    """
    lines, id, inside = [], "", False
    for line in [*words.splitlines(), ""]:
        if id:  # the line below a heading opens the block, or the scene has none
            lines, inside, id = [*lines, f'id = "{id}"'], line == BEGIN, ""
        elif inside:
            inside = line != END
            lines.append(line if inside else "")
        else:
            heading = HEADING.match(line)
            id = heading[1] if heading else ""
            lines.append("[[scenes]]" if heading else "")
    return read_table(file, "\n".join(lines))


def read_path(top: Table, knobs: Sequence[Knob], tasks: Sequence[str], words: Mapping[str, SceneWords], again: bool) -> tuple[Scene, ...]:
    """`[[scenes]]`; `again` says whether the lesson has a second prediction. Raises LessonFileError."""
    scenes: list[Scene] = []
    for table in top.tables("scenes"):
        scene = _scene(table.only(*SCENE_KEYS), knobs, tasks, words, again)
        if scene.id in [other.id for other in scenes]:
            raise table.refuse("id", text("There are two scenes {id}; choose another name.", id=scene.id))
        scenes.append(scene)
    return tuple(scenes)


def _scene(table: Table, knobs: Sequence[Knob], tasks: Sequence[str], words: Mapping[str, SceneWords], again: bool) -> Scene:
    id, shown, drawn = table.words("id"), table.names("knobs", [knob.name for knob in knobs if not knob.hidden]), table.names("figures")
    for key, names, most in (("knobs", shown, MAX_KNOBS), ("figures", drawn, MAX_FIGURES)):
        if len(names) > most:
            raise table.refuse(key, text("A scene shows at most {most} of the {key}; this one names {count}.", most=most, key=key,
                                         count=len(names)))
    minutes = table.number("minutes", 2.0)
    if minutes <= 0:
        raise table.refuse("minutes", text("minutes must be positive; it is {minutes:g}.", minutes=minutes))
    action = table.one_of("do", ACTIONS, "read")
    for key, owner in ACTION_KEYS.items():
        if key in table.data and action != owner:
            raise table.refuse(key, text('Only a scene with do = "{owner}" may have {key}; this one has do = "{action}".', owner=owner,
                                         key=key, action=action))
    if action == Question.SECOND.value and not again:
        raise table.refuse("do", text("This scene asks the second prediction, and the lesson has no table [again]."))
    if "told" in table.data and action not in ("choose", "predict", "again"):
        raise table.refuse("told", text("Only a scene that asks a question may have told."))
    options = len(words[id].options) if id in words else 0
    return Scene(id, _action(action, table, knobs, tasks, options), read_values(table, "set", knobs), read_values(table, "play", knobs),
                 shown, drawn, table.names("boards"), table.names("formulas"), table.switch("runs", True),
                 table.one_of("camera", ("", *get_args(Camera)), ""), minutes, table.switch("core", True),
                 table.names("lines"), _moment(table, "moment"), _moment(table, "told"))


def _moment(table: Table, key: str) -> float | None:
    """The share of its run at which a scene rests, None where it says none."""
    if key not in table.data:
        return None
    share = table.number(key)
    if not 0 <= share <= 1:
        raise table.refuse(key, text("{key} is a share of the run, 0 to 1; it is {share:g}.", key=key, share=share))
    return share


def _action(action: str, table: Table, knobs: Sequence[Knob], tasks: Sequence[str], options: int) -> Do:
    match action:
        case "predict" | "again":
            return Choose(Question(action))
        case "choose":
            return Choose(answer=right_option(table, options))
        case "move":
            moved = table.names("move", [knob.name for knob in knobs]) or table.names("knobs")
            if not moved:
                raise table.refuse("do", text("A scene that asks to move a knob must name it in knobs or in move."))
            return Move(moved, _goal(table, knob_named(table, "move", moved[0], knobs)) if "goal" in table.data else None)
        case "solve":
            return Solve(table.one_of("task", tasks))
        case "play" | "kick" | "pull":
            return Press(action)
        case _:
            return Read()


def _goal(table: Table, knob: Knob) -> Goal:
    """`goal`: where the first knob that is moved must end."""
    goal = table.table("goal").only("way", "least", "most", "value")
    least, most = (goal.number(key) if key in goal.data else None for key in ("least", "most"))
    value = goal.data.get("value")
    return Goal(cast(Way, goal.one_of("way", get_args(Way), "")), least, most, None if value is None else check_value(goal, "value", knob))


def right_option(table: Table, options: int) -> int:
    """The index of the right option, which a file counts from 1. Raises LessonFileError."""
    answer = table.number("answer")
    if answer not in range(1, options + 1):
        raise table.refuse("answer", text("answer must be the number of the right option, 1 to {most}; it is {answer:g}.", most=options,
                                          answer=answer) if options else
                           text("answer names the right option, and the words list no options."))
    return int(answer) - 1


def check_shown(top: Table, figures: Sequence[str], boards: Sequence[str], formulas: Sequence[str]) -> None:
    """What the scenes show, and what the second prediction veils, is there. Raises LessonFileError."""
    for table in (*top.tables("scenes"), *([top.table("again")] if "again" in top.data else ())):
        for key, there in (("figures", figures), ("boards", boards), ("formulas", formulas)):
            table.names(key, there)
