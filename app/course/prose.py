"""Read the words of a lesson from `en.md` and from `<id>.md` of every other language.

The form of such a file (headings are keywords, the rest is Markdown with $LaTeX$):

    # title
    > driving question
    introduction
    ## predict
    question
    - option
      > why it is wrong, below each option but the right one
    ### reveal
    what is really so, shown after the prediction
    ## again
    a second prediction, in the same form, for the knob that surprises most
    ## step first heading
    text
    ## derive heading of a step of the derivation
    $$equation$$
    how it follows
    ### why
    why this step is taken
    ### now
    $$equation with [[places]] for the present numbers$$
    ## task id: title
    statement
    - hint
    - hint
    ### solution
    why the solution works
    ## exam id: title
    statement with $[[places]]$ for the numbers given
    ### derivation
    how the answer follows, and $$equations with [[places]]$$; `[[answer]]` is the answer
    ## scene id: title
    a scene of the path, in the form of `read_scenes`; in the folder of a built-in lesson `path.md` has them
    ## source
    where it comes from
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, assert_never, get_args

from ..text.languages import folder_of, languages
from .exercises.derivation import DerivationStep, derived_step
from .glossary import Glossary, glossaries_in
from .glossary import ProseError as ProseError
from .scenes import SceneWords

SectionKind = Literal["predict", "again", "step", "derive", "task", "exam", "scene", "source"]
SECTION_KINDS: tuple[SectionKind, ...] = get_args(SectionKind)
SCENE_DATA = re.compile(r"^(## [^\n]*\n)```toml\n.*?^```\n", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class PredictionWords:
    """A prediction: `refutations` stand beside `options`: what refutes each, empty for the right one."""

    question: str
    options: tuple[str, ...]
    refutations: tuple[str, ...]
    reveal: str


@dataclass(frozen=True)
class TaskWords:
    """Statement, hints and solution of one task."""

    title: str
    statement: str
    hints: tuple[str, ...]
    solution: str


@dataclass(frozen=True)
class ExamWords:
    """Statement of an exam, and how its answer follows, both with places for the numbers drawn."""

    title: str
    statement: str
    derivation: str


@dataclass(frozen=True)
class Prose:
    """All words of a lesson in one language. `refutations` stand beside `options`: what refutes each, empty for the right one."""

    title: str
    question: str
    introduction: str
    predict: str
    options: tuple[str, ...]
    refutations: tuple[str, ...]
    reveal: str
    steps: tuple[tuple[str, str], ...]
    tasks: Mapping[str, TaskWords]
    exams: Mapping[str, ExamWords]
    source: str
    derivation: tuple[DerivationStep, ...] = ()
    again: PredictionWords | None = None
    scenes: Mapping[str, SceneWords] = field(default_factory=dict)  # of the lesson's path, from `path.md`
    references: tuple[str, ...] = ()  # what to read on, from the end of the notes for the teacher
    terms: tuple[Path, str] | None = field(default=None, compare=False)  # the folder and the language of the glossary

    @property
    def glossary(self) -> Glossary | None:
        """The terms that the texts of this lesson may use, None of a lesson without a glossary."""
        return None if self.terms is None else glossaries_in(self.terms[0])[self.terms[1]]


def read_prose(folder: Path) -> dict[str, Prose]:
    """The prose of a lesson by language: its own `en.md`, and `<id>.md` in the folder of every other language.

    A language that has none yet shows the English. Raises ProseError.
    """
    own, name = folder / "en.md", f"{_id(folder)}.md"
    files = {lang: (folder_of(lang) or folder) / name for lang in languages()}
    return {lang: replace(parse_prose((path if path.is_file() else own).read_text(encoding="utf-8"), f"{lang}/{name}"),
                          references=_references(folder, lang), scenes=read_scenes(folder, lang),
                          terms=(folder.parent, lang)) for lang, path in files.items()}


def read_notes(folder: Path, language: str) -> str:
    """The notes for the teacher of a lesson in Markdown: `<id>.teacher.md` of the language, the lesson's own `teacher.md` without it."""
    path = (folder_of(language) or folder) / f"{_id(folder)}.teacher.md"
    return (path if path.is_file() else folder / "teacher.md").read_text(encoding="utf-8")


def _references(folder: Path, language: str) -> tuple[str, ...]:
    """The items under the last heading of the notes for the teacher; none where there are no notes."""
    if not (folder / "teacher.md").is_file():
        return ()
    return _bullets(read_notes(folder, language).rpartition("\n## ")[2])[1]


def _id(folder: Path) -> str:
    return folder.name.replace("_", "-")


def parse_prose(text: str, name: str = "text") -> Prose:
    """Parse one file of the form above. Raises ProseError naming what is missing."""
    head, *sections = ("\n" + text.strip()).split("\n## ")
    lines = head.strip().splitlines()
    if not lines or not lines[0].startswith("# "):
        raise ProseError(f"{name} must begin with '# title'.")
    question = " ".join(line[2:].strip() for line in lines if line.startswith("> "))
    introduction = "\n".join(line for line in lines[1:] if not line.startswith("> ")).strip()
    first, again, source = PredictionWords("", (), (), ""), None, ""
    steps: list[tuple[str, str]] = []
    derivation: list[DerivationStep] = []
    tasks: dict[str, TaskWords] = {}
    exams: dict[str, ExamWords] = {}
    scenes: dict[str, SceneWords] = {}
    for section in sections:
        kind, rest, body = _section(section, name)
        match kind:
            case "predict":
                first = _asked(body)
            case "again":
                again = _asked(body)
            case "step":
                steps.append((rest, body.strip()))
            case "derive":
                derivation.append(derived_step(rest, body))
            case "task":
                tasks.update([_task(rest, body)])
            case "exam":
                exams.update([_exam(rest, body)])
            case "scene":
                key, _, label = rest.partition(":")
                scenes[key.strip()] = _scene(label.strip(), body)
            case "source":
                source = body.strip()
            case _:
                assert_never(kind)
    prose = Prose(lines[0][2:].strip(), question, introduction, first.question, first.options, first.refutations, first.reveal,
                  tuple(steps), tasks, exams, source, tuple(derivation), again, scenes)
    for part in ("question", "introduction", "predict", "reveal", "source"):
        if not getattr(prose, part):
            raise ProseError(f"{name} has no {part}.")
    return prose


def _section(section: str, name: str) -> tuple[SectionKind, str, str]:
    """The kind of a section, the rest of its heading, and its body. Raises ProseError naming the kinds that exist."""
    title, _, body = section.partition("\n")
    word, _, rest = title.strip().partition(" ")
    kind = next((each for each in SECTION_KINDS if each == word), None)
    if kind is None:
        raise ProseError(f"{name} has a section '## {title}'; use {', '.join(SECTION_KINDS[:-1])} or {SECTION_KINDS[-1]}.")
    return kind, rest.strip(), body


def _task(heading: str, body: str) -> tuple[str, TaskWords]:
    """The id of a task and its words."""
    key, _, label = heading.partition(":")
    body, _, solution = body.partition("\n### solution")
    statement, hints = _bullets(body)
    return key.strip(), TaskWords(label.strip(), statement, hints, solution.strip())


def _exam(heading: str, body: str) -> tuple[str, ExamWords]:
    """The id of an exam and its words."""
    key, _, label = heading.partition(":")
    statement, _, derived = body.partition("\n### derivation")
    return key.strip(), ExamWords(label.strip(), statement.strip(), derived.strip())


def read_scenes(folder: Path, language: str) -> dict[str, SceneWords]:
    """The words of a lesson's path by scene: `<id>.path.md` of the language, the lesson's own `path.md` without it; empty without a path.

    Each scene is a section `## id: title` with its text and options, then `### do`, `### say`, `### note` as far as it has them. The
    block of TOML below a heading is the scene's data (`scenes_of` in `reading/scenes.py`).
    """
    path = (folder_of(language) or folder) / f"{_id(folder)}.path.md"
    path = path if path.is_file() else folder / "path.md"
    words = SCENE_DATA.sub(r"\1", path.read_text(encoding="utf-8")) if path.is_file() else ""
    sections = ("\n" + words.strip()).split("\n## ")[1:]
    found = {}
    for section in sections:
        title, _, body = section.partition("\n")
        key, _, label = title.partition(":")
        found[key.strip()] = _scene(label.strip(), body)
    return found


def _scene(title: str, body: str) -> SceneWords:
    parts = dict.fromkeys(("do", "say", "note"), "")
    head, *rest = re.split(r"\n### (do|say|note)\n", "\n" + body)
    for name, words in zip(rest[::2], rest[1::2], strict=True):
        parts[name] = words.strip()
    asked = _asked(head)
    return SceneWords(title, asked.question, asked.options, asked.refutations, **parts)


def _asked(body: str) -> PredictionWords:
    """A prediction; what refutes an option are its indented lines that begin with `>`."""
    body, _, reveal = body.partition("\n### reveal")
    kept: list[str] = []
    refutations: list[str] = []
    for line in body.strip().splitlines():
        if line.startswith("- "):
            refutations.append("")
        if refutations and line.startswith("  > "):
            refutations[-1] = f"{refutations[-1]} {line[4:].strip()}".strip()
        else:
            kept.append(line)
    return PredictionWords(*_bullets("\n".join(kept)), tuple(refutations), reveal.strip())


def _bullets(body: str) -> tuple[str, tuple[str, ...]]:
    """The text before a list and the items of the list; an item may go on over indented lines."""
    text: list[str] = []
    items: list[str] = []
    for line in body.strip().splitlines():
        if line.startswith("- "):
            items.append(line[2:].strip())
        elif items and line.startswith("  "):
            items[-1] += " " + line.strip()
        else:
            text.append(line)
    return "\n".join(text).strip(), tuple(items)
