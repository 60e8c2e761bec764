"""Write recorded lessons as a folder: one page, and a script file for each scene in each look."""

from __future__ import annotations

import hashlib
import html
import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..course.lesson import Lesson
from ..page.record.published_page import published_page
from ..page.record.questions_page import questions_page
from ..page.record.recorded_screen import Look
from ..session.commands.shortcuts import SHORTCUTS
from .packing import Arrays, Table, data_file, difference, pack_run
from .points import Points
from .recorder import RecordedScene, RecordedState, Recorder
from .screens import Values

DATA = "data"
SKETCH = re.compile(r'data-sketch="([^"]*)"')  # in the HTML of a question's figure
Write = Callable[[str, str], object]  # the name of a file in the folder, and its text


def write_lesson(lessons: Mapping[str, Lesson], lesson: str, looks: Sequence[Look], points: Points, write: Write,
                 advance: Callable[[], object] = lambda: None) -> None:
    """Record one lesson and write its files; `advance` is called after each scene."""
    recorder = Recorder(lessons, lesson, looks, points)
    recorder.begin(0)
    bases, overlays = recorder.screens.standing(), recorder.overlays()
    scenes = []
    for index in range(len(recorder.path)):
        scene = recorder.scene(index)
        scenes.append({"id": scene.id, "action": scene.action, "lacks": scene.lacks,
                       "states": [[state.name, state.done] for state in scene.states]})
        _write_scene(lesson, scene, looks, bases, write)
        advance()
    for k, look in enumerate(looks):
        arrays = Arrays()
        places, values = Table(arrays), Table(arrays)
        pairs = [[places.add(list(place)), values.add(value)] for place, value in bases[k].items()]
        shown = {name: difference(bases[k], standing[k], places, values) for name, standing in overlays.items()}
        content = {"places": places.kept, "values": values.kept, "base": pairs, "overlays": shown, "scenes": scenes,
                   "commands": {shortcut.label(look.language): type(shortcut.command).__name__ + _detail(shortcut.command)
                                for shortcut in SHORTCUTS}}
        name = f"{lesson}/{look.name}"
        write(f"{DATA}/{name}.js", data_file(name, content, arrays.kept))


def _detail(command: Any) -> str:
    return "".join(f":{getattr(command, name)}" for name in command.__struct_fields__)


def _write_scene(lesson: str, scene: RecordedScene, looks: Sequence[Look], bases: Sequence[Values], write: Write) -> None:
    arrays, runs, numbers = Arrays(), list[dict[str, Any]](), dict[int, int]()
    for state in scene.states:
        if state.run is not None:
            packed = pack_run(state.run, arrays)
            if packed not in runs:
                runs.append(packed)
            numbers[id(state)] = runs.index(packed)
    for k, look in enumerate(looks):
        places, values = Table(arrays), Table(arrays)
        states = [_state(state, k, bases[k], places, values, numbers.get(id(state), -1)) for state in scene.states]
        content = {"places": places.kept, "values": values.kept, "states": states, "knobs": _widgets(scene.states, k),
                   "sketch": _sketch(scene, k)}
        name = f"{lesson}/{scene.id}/{look.name}"
        write(f"{DATA}/{name}.js", data_file(name, content))
    name = f"{lesson}/{scene.id}/arrays"
    write(f"{DATA}/{name}.js", data_file(name, {"runs": runs}, arrays.kept))


def _state(state: RecordedState, look: int, base: Values, places: Table, values: Table, run: int) -> dict[str, Any]:
    return {"name": state.name, "patch": difference(base, state.values[look], places, values),
            "steps": [difference(base, step[look], places, values) for step in state.steps],
            "run": run, "told": values.add(dict(state.told[look])), "t": state.t, "rest": state.rest, "part": state.part,
            "done": state.done, "runs": state.runs, "held": dict(state.held)}


def _sketch(scene: RecordedScene, look: int) -> dict[str, Any] | None:
    """What a page must know to find the option that is nearest to a drawing, None where nothing is drawn by hand."""
    told = [SKETCH.search(value) for value in scene.states[0].values[look].values() if isinstance(value, str) and scene.sketches]
    found = next(filter(None, told), None)
    if found is None:
        return None
    return {**json.loads(html.unescape(found[1])), "options": scene.sketches, "mark": 'data-figure="question"'}


def _widgets(states: Sequence[RecordedState], look: int) -> dict[str, list[str]]:
    """The widgets by which each knob is moved: those that show another value where it alone has one."""
    entry, out = states[0].values[look], dict[str, list[str]]()
    for state in states:
        if len(state.held) != 1:
            continue
        found = out.setdefault(state.held[0][0], [])
        for place, value in state.values[look].items():
            entity, prop = place
            if prop == "value" and entity.startswith("gui:") and entity not in found and entry.get(place) != value \
                    and state.values[look].get((entity, "visible")):
                found.append(entity)
    return out


def write_folder(lessons: Mapping[str, Lesson], looks: Sequence[Look], folder: Path) -> None:
    """Write the page of these lessons, and the questions that they answer in each language."""
    write_file(folder, "index.html", published_page([*dict.fromkeys(look.language for look in looks)], list(lessons),
                                                    [look.name for look in looks], DATA))
    for language in dict.fromkeys(look.language for look in looks):
        write_file(folder, f"questions-{language}.html", questions_page(lessons, language, "index.html"))


def write_file(folder: Path, name: str, words: str) -> None:
    """Write a file of the folder."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(words, encoding="utf-8")


def key_of(sources: Sequence[Path], *settings: object) -> str:
    """What the files of a lesson depend on, in one word: all sources of the lab, and how they are recorded."""
    found = hashlib.sha256(repr(settings).encode())
    for root in sources:
        for path in sorted(path for path in root.rglob("*") if path.is_file() and "__pycache__" not in path.parts):
            found.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()


def is_written(folder: Path, lesson: str, key: str) -> bool:
    """Whether the files of a lesson stand in the folder as this key makes them."""
    note = folder / DATA / lesson / "key.txt"
    return note.is_file() and note.read_text(encoding="utf-8") == key


def record_lesson(lessons: Mapping[str, Lesson], lesson: str, looks: Sequence[Look], points: Points, folder: Path, key: str,
                  advance: Callable[[], object] = lambda: None) -> None:
    """Write the files of one lesson into the folder, and at the end the key that they belong to."""
    write_lesson(lessons, lesson, looks, points, lambda name, words: write_file(folder, name, words), advance)
    write_file(folder, f"{DATA}/{lesson}/key.txt", key)
