"""`glossary`: what a term means, in words and as a formula."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..options import CommandError, add_json

if TYPE_CHECKING:
    from ...course.glossary import Entry

HELP = "print what a term means"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `glossary`."""
    from ...text.languages import languages

    parser.add_argument("term", nargs="*", metavar="TERM", help="a term, such as observer gain; all terms without one")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the explanations")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print one entry or all. Raises CommandError at a term that has none, naming those that are spelled like it."""
    from dataclasses import asdict

    from observer_lab.lessons import glossaries

    from ..printing import print_json

    glossary, asked = glossaries()[options.lang], " ".join(options.term)
    found = glossary.entry(asked) or glossaries()["en"].entry(asked)
    if asked and found is None:
        near = difflib.get_close_matches(asked.lower(), [form for each in glossary.entries for form in each.forms], 3)
        raise CommandError(f"The glossary has no term {asked[:40]}; " + (f"it has {', '.join(near)}." if near else
                           "print all terms by: observer-lab glossary."))
    shown = [each for each in glossary.entries if found is None or each.id == found.id]
    if options.json:
        print_json([asdict(each) for each in shown])
    else:
        print(in_markdown(shown))
    return 0


def in_markdown(entries: Iterable[Entry]) -> str:
    """Entries as items of a list in Markdown."""
    return "\n".join(f"- **{each.term}**: {each.text} ${each.formula}$" for each in entries)
