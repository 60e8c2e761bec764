"""Write recorded lessons as a folder: one page, and script files for each scene."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ..course.lectures import Lecture
from ..course.lesson import Lesson
from ..engine.kernels import prepare_kernels
from ..page.record.published_page import lecture_page, published_page, questions_page
from ..page.record.recorded_screen import Look
from ..session.commands.commands import (
    ChangeSpeed,
    Command,
    Kick,
    LookFrom,
    Play,
    Reset,
    Rewind,
    SetLanguage,
    ToggleCourse,
    ToggleHelp,
    ToggleTheme,
    TurnPage,
)
from ..session.commands.guide import ToggleGlossary
from ..session.commands.shortcuts import SHORTCUTS
from .packing import Arrays, Runs, Tables, data_file
from .points import Points
from .recorder import RecordedScene, RecordedState, Recorder
from .screens import Values
from .store import Write, write_file

DATA, PAGE = "data", "index.html"
ACTS: Mapping[Command, str] = MappingProxyType({  # what `published.js` does for a key
    Play(): "play", Kick(): "kick", Rewind(): "rewind", ChangeSpeed(-1): "slower", ChangeSpeed(+1): "faster", Reset(): "reset",
    ToggleCourse(): "course", TurnPage(+1): "page:1", TurnPage(-1): "page:-1", SetLanguage(): "language", ToggleTheme(): "theme",
    ToggleGlossary(): "terms", ToggleHelp(): "help", LookFrom("all"): "view", LookFrom("plant"): "view", LookFrom("boards"): "view"})
SKETCH = re.compile(r'data-sketch="([^"]*)"')  # in the HTML of a question's figure


def write_lesson(lessons: Mapping[str, Lesson], lesson: str, looks: Sequence[Look], points: Points, write: Write,
                 advance: Callable[[], object] = lambda: None) -> None:
    """Record one lesson and write its files, named from its own folder; `advance` is called after each scene.

    The compiled kernels are made ready first, as a server does: the plain ways differ from them by rounding.
    """
    prepare_kernels().join()
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
    tables, dialogs = ({look.language: Tables() for look in looks} for _ in range(2))
    for k, look in enumerate(looks):
        content = {"base": tables[look.language].difference({}, bases[k]), "scenes": scenes,
                   "commands": {each.label(look.language): ACTS[each.command] for each in SHORTCUTS if each.command in ACTS}}
        shown = {name: dialogs[look.language].difference(bases[k], standing[k]) for name, standing in overlays.items()}
        write(f"{look.name}.js", data_file(f"{lesson}/{look.name}", content))
        write(f"{look.name}-dialogs.js", data_file(f"{lesson}/{look.name}-dialogs", {"overlays": shown}))
    for suffix, found in (("", tables), ("-dialogs", dialogs)):  # pictures of all lessons are in a dialog, which few open
        for language, table in found.items():
            write(f"{language}{suffix}.js", data_file(f"{lesson}/{language}{suffix}", table.content, table.arrays.kept))


def _write_scene(lesson: str, scene: RecordedScene, looks: Sequence[Look], bases: Sequence[Values], write: Write) -> None:
    arrays = Arrays()
    runs, numbers = Runs(arrays), dict[int, int]()
    for state in scene.states:
        if state.run is not None:
            numbers[id(state)] = runs.add(state.run)
    tables = {look.language: Tables(arrays) for look in looks}
    for k, look in enumerate(looks):
        states = [_state(state, k, bases[k], tables[look.language], numbers.get(id(state), -1)) for state in scene.states]
        content = {"states": states, "knobs": _widgets(scene.states, k), "sketch": _sketch(scene, k)}
        write(f"{scene.id}/{look.name}.js", data_file(f"{lesson}/{scene.id}/{look.name}", content))
    for language, table in tables.items():
        write(f"{scene.id}/{language}.js", data_file(f"{lesson}/{scene.id}/{language}", table.content))
    write(f"{scene.id}/arrays.js", data_file(f"{lesson}/{scene.id}/arrays", {"runs": runs.kept}, arrays.kept))


def _state(state: RecordedState, look: int, base: Values, tables: Tables, run: int) -> dict[str, Any]:
    return {"name": state.name, "patch": tables.difference(base, state.values[look]),
            "steps": [tables.difference(base, step[look]) for step in state.steps],
            "run": run, "told": tables.values.add(dict(state.told[look])), "t": state.t, "rest": state.rest, "part": state.part,
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


def write_folder(lessons: Mapping[str, Lesson], looks: Sequence[Look], folder: Path, lecture: Lecture | None = None) -> None:
    """Write the page of these lessons, and in each language the questions that they answer and the scenes of the lecture."""
    spoken = [*dict.fromkeys(look.language for look in looks)]
    stops = [(stop.lesson, stop.scene) for stop in lecture.stops] if lecture is not None else []
    pages = {language: f"lecture-{language}.html" for language in spoken} if lecture is not None else {}
    write_file(folder, PAGE, published_page(spoken, list(lessons), [look.name for look in looks], DATA, stops, pages))
    for language in spoken:
        write_file(folder, f"questions-{language}.html", questions_page(lessons, language, PAGE))
        if lecture is not None:
            write_file(folder, pages[language], lecture_page(lecture, lessons, language, PAGE))
