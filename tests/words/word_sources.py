"""Every English and Chinese sentence that a person can meet, with the file and line where it stands."""

from __future__ import annotations

import ast
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from babel.messages.pofile import read_po
from catalogues import SOURCES, comments, said
from syntax import nodes

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md")
PHRASES = ("glossary.md", "questions.md")  # whose lists are words to be found by, not sentences
SHORT = ("e.g", "i.e", "Fig", "vs", "cf", "No", "Eq", "approx", "resp", "Dr", "Prof", "et al", "p", "pp", "vol")
INITIAL = re.compile(r"(?:^|(?<![\d$\]]) )[A-Z]\.$")
STOP = re.compile(r"(?:(?<=[.!?…])|(?<=[.!?…][”\")*]))\s+(?=[“\"(*$\[`]*[A-Z0-9\"“$`\[{‖√∫Σ])")
FENCE = re.compile(r"^\s*```")
ITEM = re.compile(r"^\s*(?:[-*] |\d+\. |> ?)+")
ROW = re.compile(r"^\s*\|(.+)\|\s*$")
CHINESE = "app/locale/zh/"
CHINESE_STOP = re.compile(r"(?<=[。？！])(?=.)")
ERRORS = re.compile(r"^[A-Z]\w*(?:Error|Refusal)$")
HELP_NAMES = re.compile(r"^(?:[A-Z_]*HELP|help|description|epilog|metavar_help)$")


@dataclass(frozen=True)
class Sentence:
    """One sentence and where it begins."""

    words: str
    file: str
    line: int
    script: bool = False  # a comment of an exported script, in ASCII

    @property
    def where(self) -> str:
        """File and line."""
        return f"{self.file}:{self.line}"


def sentences(text: str) -> list[str]:
    """The sentences of a paragraph; an abbreviation, an initial or a number with its point ends none."""
    parts: list[str] = []
    for part in STOP.split(text.strip()):
        if parts and (parts[-1].rpartition(" ")[2].rstrip(".").lstrip("(") in SHORT or INITIAL.search(parts[-1])):
            parts[-1] += " " + part
        elif part:
            parts.append(part)
    return parts


def markdown(text: str, file: str) -> Iterator[Sentence]:
    """The sentences of a Markdown file: headings, paragraphs, items and cells; no code, no displayed formulas, no comments."""
    block: list[str] = []
    start, fenced = 0, False
    for number, line in enumerate([*text.splitlines(), ""], 1):
        if FENCE.match(line):
            fenced = not fenced
        ends = not line.strip() or line.startswith("#") or ITEM.match(line) or ROW.match(line) or FENCE.match(line) or line.startswith("$$")
        if block and (ends or fenced):
            yield from _block(block, file, start)
            block = []
        if fenced or FENCE.match(line) or line.startswith(("$$", "<!--")) or not line.strip():
            continue
        if cells := ROW.match(line):
            for cell in cells[1].split("|"):
                if cell.strip(" :-"):
                    yield from _block([cell.strip()], file, number)
        elif line.startswith("#"):
            if heading := _heading(line):
                yield Sentence(heading, file, number)
        else:
            start = start if block else number
            block.append(ITEM.sub("", line).strip() if ITEM.match(line) else line.strip())


def _heading(line: str) -> str:
    """The words of a heading, without the keyword and the id of a section of a lesson."""
    words = line.lstrip("#").strip()
    words = re.sub(r"^(?:step|derive|(?:(?:task|exam) )?[a-z-]+:) ", "", words)
    return "" if words in ("predict", "again", "reveal", "why", "now", "solution", "derivation", "source", "do", "say", "note") else words


def _block(lines: list[str], file: str, start: int) -> Iterator[Sentence]:
    """Sentences of joined lines; each is placed at the line on which it begins."""
    text, at = " ".join(lines), 0
    ends = [sum(len(each) + 1 for each in lines[: k + 1]) for k in range(len(lines))]
    for one in sentences(text):
        at = max(text.find(one, at), at)
        yield Sentence(one, file, start + sum(end <= at for end in ends))
        at += len(one)


def messages() -> Iterator[Sentence]:
    """Every message that is translated, and the comments of exported scripts."""
    for (context, english), where in said().items():
        if context != "script":
            file, _, line = where.rpartition(":")
            yield from (Sentence(one, file, int(line)) for one in sentences(english))
    for comment, where in comments():
        yield from (Sentence(one, where, 0, True) for one in sentences(comment))


def untranslated() -> Iterator[Sentence]:
    """English that no catalogue has: help and errors of the command line, errors that are raised with a plain string."""
    for path in SOURCES:
        file = path.relative_to(ROOT).as_posix()
        for node in nodes(path.read_text(encoding="utf-8")):
            for said_here, line in _plain(node):
                for one in sentences(said_here):
                    if re.search(r"[A-Za-z]{2} [A-Za-z]", one):
                        yield Sentence(one, file, line)


def _plain(node: ast.AST) -> Iterator[tuple[str, int]]:
    if isinstance(node, ast.Call):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if ERRORS.match(name) or name == "ArgumentTypeError":
            yield from ((words, node.lineno) for argument in node.args if (words := _string(argument)))
        yield from ((words, node.lineno) for keyword in node.keywords
                    if HELP_NAMES.match(keyword.arg or "") and (words := _string(keyword.value)))
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and HELP_NAMES.match(node.targets[0].id):
        yield _string(node.value), node.lineno


def _string(node: ast.expr) -> str:
    """A string as it is written, with {x} for what is put in; empty for anything else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(_string(part) if isinstance(part, ast.Constant) else "{x}" for part in node.values)
    return ""


def pages() -> list[Path]:
    """The Markdown files that a person reads in English."""
    folder = ROOT / "lessons"
    return [*(ROOT / name for name in PAGES), *sorted(folder.glob("**/*.md")), *sorted((ROOT / "app" / "course").glob("**/*.md"))]


def _shown(path: Path) -> str:
    """The text of a page, of a list of phrases without the phrases."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"^(?:- |→).*$", "", text, flags=re.M) if path.name == "questions.md" else text


def chinese() -> Iterator[Sentence]:
    """The Chinese sentences; of the glossary without the other forms by which it finds a term."""
    for path in sorted((ROOT / CHINESE).iterdir()):
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".md":
            found = markdown(re.sub(r"^- .*$", "", text, flags=re.M) if path.name in PHRASES else text, CHINESE + path.name)
        else:
            found = (Sentence(one.string, CHINESE + path.name, one.lineno or 0, path.name == "comments.po")
                     for one in read_po(io.StringIO(text)) if one.id and isinstance(one.string, str))
        for one in found:
            yield from (replace(one, words=part) for part in CHINESE_STOP.split(one.words) if part.strip())


def every_sentence() -> list[Sentence]:
    """All of them: pages, messages, errors and help, and what stands in Chinese."""
    found = [one for path in pages() for one in markdown(_shown(path), path.relative_to(ROOT).as_posix())]
    found += [*messages(), *untranslated(), *chinese()]
    return [*dict.fromkeys(found)]


def of_files(names: Iterable[str]) -> list[Sentence]:
    """The sentences of files or folders, as given on a command line; of all files for no name."""
    wanted = [Path(name).resolve() for name in names]
    if not wanted:
        return every_sentence()
    return [one for one in every_sentence() if any((ROOT / one.file).is_relative_to(each) for each in wanted)]
