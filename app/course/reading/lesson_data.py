"""Read the data of a lesson, and gather the lesson of a folder from its files and modules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any

from ...text import text
from ..course_map import LEARNING_PATHS, CoursePlace
from ..exercises.second_prediction import SecondPrediction
from ..knobs import Knob
from ..prose import Prose, read_prose
from ..scenes import minutes_of
from .scenes import read_path, right_option, scenes_of
from .toml_table import Table, read_table, read_values, refusal

DATA_KEYS = ("draft", "minutes", "answer", "figure", "key", "aside", "kick", "again")  # of every lesson
COURSE_KEYS = ("number", "source", "needs", "ways", "universal", "bilinear")  # of a lesson of the course
AGAIN_KEYS = ("knobs", "answer", "trial", "figures", "numbers")
DEFAULT_MINUTES = 45  # of a lesson without a path
DATA, SCENES, WORDS, CARD = "lesson.toml", "path.md", "en.md", "card.webp"
NEEDED = ("knobs", "compute", "figures", "tasks")
PARTS: Mapping[str, tuple[str, str]] = MappingProxyType({  # field of a lesson → its module and its name there
    "knobs": ("knobs", "KNOBS"), "compute": ("study", "compute"), "figures": ("figures", "figures"), "tasks": ("tasks", "TASKS"),
    "exams": ("exams", "EXAMS"), "derived": ("derive", "derived"), "code": ("code", "code"), "job": ("job", "JOB"),
    "device": ("device", "device"), "device_parts": ("device", "PARTS"), "estimates": ("estimates", "estimates"),
    "questions": ("questions", "QUESTIONS"), "pick": ("job", "pick"), "seeds": ("seeds", "run_seeds"), "adapt": ("own", "adapted"),
    "take_record": ("own", "with_record")})


def read_folder(modules: Sequence[ModuleType], given: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of the lesson whose folder holds these modules; `given` are those that no module has by its name.

    Raises LessonFileError or ProseError.
    """
    folder = Path(str(modules[0].__file__)).parent
    rooms = {module.__name__.rpartition(".")[2]: vars(module) for module in modules}
    parts = {field: rooms[room][name] for field, (room, name) in PARTS.items() if name in rooms.get(room, {})} | dict(given)
    for field in NEEDED:
        if field not in parts:
            raise refusal(f"{folder.name}/lesson.py", 1, text("The lesson needs {name} in {room}.py, and lesson.py must name that module.",
                                                              name=PARTS[field][1], room=PARTS[field][0]))
    words = read_prose(folder)
    top = read_table(f"{folder.name}/{DATA}", (folder / DATA).read_text(encoding="utf-8")).only(*DATA_KEYS, *COURSE_KEYS)
    path = folder / SCENES
    scenes = scenes_of(f"{folder.name}/{SCENES}", path.read_text(encoding="utf-8") if path.is_file() else "")
    fields = read_data(top, scenes, parts["knobs"], [task.id for task in parts["tasks"]], words["en"], WORDS)
    ways = tuple(LEARNING_PATHS[name] for name in top.names("ways", LEARNING_PATHS))
    card = folder / CARD
    fields["place"] = CoursePlace(fields["place"].minutes, top.names("needs"), ways, card if card.is_file() else None)
    switches = {key: top.switch(key, False) for key in ("universal", "bilinear")}
    return {"id": folder.name.replace("_", "-"), "number": int(top.number("number")), "source": top.words("source"), "words": words,
            **fields, **switches, **parts}


def read_data(top: Table, scenes: Table, knobs: Sequence[Knob], tasks: Sequence[str], words: Prose, file: str) -> dict[str, Any]:
    """The fields of a lesson that need no Python: those of DATA_KEYS, and its path. Raises LessonFileError."""
    names = [knob.name for knob in knobs]
    again = _again(top.table("again"), knobs, words, file) if "again" in top.data else None
    path = read_path(scenes, knobs, tasks, words.scenes, again is not None)
    return {"answer": right_option(top, len(words.options)), "answering": top.words("figure", ""), "again": again, "path": path,
            "key": top.names("key", names), "aside": top.names("aside", names), "kick": top.switch("kick", True),
            "draft": top.switch("draft", False),
            "place": CoursePlace(round(top.number("minutes", minutes_of(path, core=False) or DEFAULT_MINUTES)))}


def _again(table: Table, knobs: Sequence[Knob], words: Prose, file: str) -> SecondPrediction:
    """`[again]`, whose words stand under `## again`."""
    table.only(*AGAIN_KEYS)
    if words.again is None:
        raise table.refuse("", text("{file} has no section “## again”.", file=file))
    return SecondPrediction(table.names("knobs", [knob.name for knob in knobs]), right_option(table, len(words.again.options)),
                            read_values(table, "trial", knobs), table.names("figures"), table.switch("numbers", False))
