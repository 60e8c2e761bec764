"""Find what answers some words: `find`."""

from __future__ import annotations

import argparse

from ..options import CommandError, add_json

HELP = "find the scene, lesson, term or function that answers your words"
MOST = 5


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `find`."""
    from ...text.languages import languages

    parser.add_argument("words", nargs="+", metavar="WORD", help="what you would type into a search field, such as missing measurements")
    parser.add_argument("--lang", choices=languages(), help="language of the answers (default: that of the words)")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print what was found, best first. Raises CommandError where nothing was."""
    from dataclasses import asdict

    from observer_lab.lessons import all_lessons

    from ...course.search.finder import find_in_any, finder, functions
    from ...text import languages
    from ..printing import print_json

    asked = " ".join(options.words)
    lessons, more = all_lessons(), functions()
    found = find_in_any((finder(lessons, code, more) for code in ([options.lang] if options.lang else languages())), asked, MOST)
    if not found:
        raise CommandError(f"Nothing answers {asked[:60]}; try other words, or print all lessons by: observer-lab list.")
    if options.json:
        print_json([{name: value for name, value in asdict(hit).items() if name != "forms"} for hit in found])
        return 0
    for k, hit in enumerate(found):
        print(f"{hit.title} ({hit.kind})")
        if hit.answer and (k == 0 or hit.kind == "question"):
            print(f"  {' '.join(hit.answer.split())}")
        if hit.lesson:
            print(f"  observer-lab link {hit.lesson}" + (f" --view guide --scene {hit.scene}" if hit.scene else ""))
        if hit.name:
            print(f"  from observer_lab.engine import {hit.name}")
    return 0
