"""The data of lessons: a scene can be written with all that it has, a wrong line is named, other languages hold words only."""

from __future__ import annotations

import re
import types
from dataclasses import fields, replace
from pathlib import Path

import pytest
from laws import each, holds_for_all

from observer_lab import lessons
from observer_lab.course.knobs import Choice, Number, Poles
from observer_lab.course.lesson import Lesson
from observer_lab.course.prose import read_scenes
from observer_lab.course.reading.scenes import ACTIONS, SCENE_KEYS, read_path, scenes_of
from observer_lab.course.reading.toml_table import LessonFileError
from observer_lab.course.scenes import Choose, Do, Goal, Move, Press, Question, Read, Scene, SceneWords, Solve
from observer_lab.text import same
from observer_lab.text.languages import folder_of, languages

FOLDERS = tuple(lessons.folder(id) for id in lessons.LESSONS)
KNOBS = (Number("k", "k", same("k"), low=0.0, high=9.0, default=1.0), Poles("q", "q", same("q"), default=(-1.0, -2.0)),
         Choice("mode", "", same("mode"), options=(("a", same("a")), ("b", same("b"))), default="a"))
WHOLE = """
## one: First
```toml
do = "choose"
answer = 2
set = { k = 3, q = [-3, "-0.5"] }
play = { q = ["-1-2j", "-1+2j"] }
knobs = ["k", "mode"]
figures = ["error"]
boards = ["left"]
formulas = ["L"]
camera = "bare"
moment = 0.25
runs = false
minutes = 1.5
core = false
```
A question?
- this
- that
## two: No data
Words only.
## three: A goal
```toml
do = "move"
move = ["q"]
goal = { way = "right", least = -0.5, most = -0.1 }
```
Words.
## four: A value
```toml
do = "move"
knobs = ["mode"]
goal = { value = "b" }
```
"""
READ = (
    Scene("one", Choose(answer=1), {"k": 3.0, "q": (-3, -0.5)}, {"q": (-1 - 2j, -1 + 2j)}, ("k", "mode"), ("error",), ("left",), ("L",),
          False, "bare", 1.5, False, (), 0.25),
    Scene("two"), Scene("three", Move(("q",), Goal("right", -0.5, -0.1))), Scene("four", Move(("mode",), Goal(value="b")), knobs=("mode",)))
ONE_ACTION = {"read": Read(), "predict": Choose(Question.FIRST), "again": Choose(Question.SECOND), "choose": Choose(answer=0),
              "move": Move(("k",)), "play": Press("play"), "kick": Press("kick"), "pull": Press("pull"), "solve": Solve("t")}
EXTRA = {"choose": "answer = 1", "move": 'knobs = ["k"]', "solve": 'task = "t"'}


def read(words: str) -> tuple[Scene, ...]:
    """The scenes of a text, in which every scene offers two options."""
    top = scenes_of("path.md", words)
    told = {table.words("id"): SceneWords("", "", ("this", "that")) for table in top.tables("scenes")}
    return read_path(top, KNOBS, ("t",), told, True)


def test_a_scene_is_read_with_all_that_it_has() -> None:
    assert read(WHOLE) == READ


def test_a_file_can_say_every_field_of_a_scene_and_of_its_action() -> None:
    """A lesson without Python does what a scene of a built-in lesson does: a new field or action needs its key."""
    assert {field.name for field in fields(Scene)} <= set(SCENE_KEYS)
    assert {type(action) for action in ONE_ACTION.values()} == set(Do.__args__) and set(ONE_ACTION) == set(ACTIONS)
    said = {name: read(f'## x: X\n```toml\ndo = "{name}"\n{EXTRA.get(name, "")}\n```\n')[0].do for name in ACTIONS}
    assert said == ONE_ACTION
    goals = [scene.do.goal for scene in READ if isinstance(scene.do, Move) and scene.do.goal]
    assert [field.name for field in fields(Goal) if all(getattr(goal, field.name) == field.default for goal in goals)] == []


@each("folder", FOLDERS)
def test_a_wrong_line_of_any_scene_is_named(folder: Path) -> None:
    lines = (folder / "path.md").read_text(encoding="utf-8").splitlines()
    lesson = lessons.LESSONS[folder.name.replace("_", "-")]
    told = {scene.id: replace(lesson.words["en"].scenes[scene.id]) for scene in lesson.path}
    for at in [number for number, line in enumerate(lines) if line == "```toml"]:
        top = scenes_of("path.md", "\n".join([*lines[:at + 1], "colour = 1", *lines[at + 1:]]))
        with pytest.raises(LessonFileError, match=rf"^path\.md, line {at + 2}: There is no key colour here; use id, do,"):
            read_path(top, lesson.knobs, [task.id for task in lesson.tasks], told, True)


def test_a_broken_block_is_one_sentence_with_its_line() -> None:
    with pytest.raises(LessonFileError, match=r"^path\.md, line 4: This is no valid TOML"):
        read("\n## x: X\n```toml\ndo = \n```\n")


def test_an_id_stands_once() -> None:
    with pytest.raises(LessonFileError, match=r"^path\.md, line 4: There are two scenes x; choose another name\."):
        read("## x: X\nWords.\n## x: X\nWords.\n")


def test_the_data_of_a_scene_stands_once_and_is_no_word_of_it() -> None:
    def only_words(folder: Path) -> None:
        name = folder.name.replace("_", "-")
        for language in languages():
            other = folder_of(language)
            if other is not None and (path := other / f"{name}.path.md").is_file():
                assert "```" not in path.read_text(encoding="utf-8"), f"{path.name}: the data stands in path.md"
            for id, words in read_scenes(folder, language).items():
                assert "```" not in repr(words) and not re.search(r"\bminutes = ", words.text), id
    holds_for_all(FOLDERS, only_words)


def test_a_module_that_is_missing_is_named() -> None:
    from observer_lab.lessons.separation import knobs, study

    with pytest.raises(LessonFileError, match=r"lesson.py, line 1: The lesson needs figures in figures.py"):
        Lesson.from_folder(knobs, study)


def test_a_module_under_another_name_is_not_taken() -> None:
    from observer_lab.lessons.separation import knobs, study

    other = types.ModuleType("x.drawing")
    vars(other).update(figures=len)
    with pytest.raises(LessonFileError, match=r"figures in figures\.py"):
        Lesson.from_folder(knobs, study, other)
