"""A language made on the fly: every sentence accented and twice as long. What is left unaccented, no one can translate."""

from __future__ import annotations

import re
from pathlib import Path

from babel.messages import Catalog, pofile
from catalogues import ROOT, said

from observer_lab.course.glossary import parse_glossary

CODE = "qps"
ACCENTS = str.maketrans("aeiouycnszAEIOUCNSZ", "áéíóúýçñšžÁÉÍÓÚÇÑŠŽ")
# what a translator leaves alone: places for values, mathematics, code, tags, links, names of LaTeX
KEPT = re.compile(r"\[\[\w+\]\]|\$+[^$]+\$+|`[^`]*`|\{[^{}]*\}|<[^>]+>|\\[A-Za-z]+|&\w+;")
SECTION = re.compile(r"^(#+ (?:predict|again|reveal|solution|exam|source|why|now|derivation)$|## (?:step|derive) |"
                     r"## (?:task|exam) [\w-]+: |#+ |- |(?:  )?> |)(.*)$")


def accented(words: str) -> str:
    """The words with accents on their vowels, what must stay as it is."""
    parts, at = [], 0
    for kept in KEPT.finditer(words):
        parts += [words[at:kept.start()].translate(ACCENTS), kept[0]]
        at = kept.end()
    return "".join(parts) + words[at:].translate(ACCENTS)


def doubled(words: str) -> str:
    """The words accented, and once more behind them."""
    once = accented(words)
    return f"{once} {once}" if any(c.isalpha() for c in KEPT.sub("", words)) else once


def prose(markdown: str) -> str:
    """A lesson's file in the language: its form stays, its sentences change."""
    lines = []
    for line in markdown.splitlines():
        found = SECTION.match(line)
        assert found is not None
        lines.append(found[1] + (doubled(found[2]) if found[2] and not line.startswith("|") else found[2]))
    return "\n".join(lines) + "\n"


def write_language(root: Path) -> Path:
    """The folder of the language, as a translator would hand it over, inside `root`."""
    folder = root / CODE
    folder.mkdir(parents=True)
    catalogue = Catalog(locale=None)
    for context, english in said():
        catalogue.add(english, doubled(english), context=context or None)
    with (folder / "all.po").open("wb") as file:
        pofile.write_po(file, catalogue)
    for path in sorted((ROOT / "lessons").glob("*/en.md")):
        name = path.parent.name.replace("_", "-")
        (folder / f"{name}.md").write_text(prose(path.read_text(encoding="utf-8")), encoding="utf-8")
    terms = parse_glossary((ROOT / "lessons" / "glossary.md").read_text(encoding="utf-8")).entries
    (folder / "glossary.md").write_text("# \n" + "".join(
        f"\n## {each.id}: {accented(each.term)}\n\n{doubled(each.text)}\n" for each in terms), encoding="utf-8")
    return folder
