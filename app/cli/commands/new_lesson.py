"""Write the files of a new lesson, a draft that opens in the page: `new-lesson`."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from ..options import CommandError, error_cause

HELP = "write a new lesson, a draft that opens in the page"
NAME = re.compile(r"[a-z]{1,30}(-[a-z]{1,30}){0,4}")
TEMPLATES, SUFFIX = Path(__file__).parents[1] / "lesson_template", ".txt"
PACKAGE, FILES = TEMPLATES / "package", TEMPLATES / "files"  # a lesson in Python for the code, one as TOML and Markdown for any folder


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `new-lesson`."""
    parser.add_argument("name", metavar="NAME", help="its name: small letters, with hyphens between words, as leaky-tank")
    parser.add_argument("--folder", metavar="DIR", help="folder for a lesson as TOML and Markdown; without it a Python package is written "
                                                        "among the lessons of this installation")


def execute(options: argparse.Namespace) -> int:
    """Write the lesson and print how to open it. Raises CommandError where its name or place cannot be used."""
    from observer_lab import lessons

    name, known = options.name, lessons.all_lessons()
    if not NAME.fullmatch(name):
        raise CommandError(f"{name[:40]} cannot name a lesson; use small letters, with hyphens between words, as in leaky-tank.")
    if name in known:
        raise CommandError(f"There is a lesson {name} already; choose another name.")
    words = name.replace("-", " ")
    number = 1 + max(each.number for each in known.values())
    values = {"@id@": name, "@title@": words, "@Title@": words.capitalize(), "@number@": str(number)}
    home = None if options.folder is None else Path(options.folder)
    place = Path(lessons.__file__).parent / name.replace("-", "_") if home is None else home / name
    write_template(PACKAGE if home is None else FILES, place, values)
    print(f"{place}\nopen it with: observer-lab serve {'' if home is None else f'--lessons {home} '}--lesson {name}")
    return 0


def write_template(template: Path, place: Path, values: dict[str, str]) -> None:
    """Every file of a template with its places filled. Raises CommandError where the folder exists or cannot be made."""
    try:
        place.mkdir(parents=True)
        for path in sorted(template.glob(f"*{SUFFIX}")):
            words = path.read_text(encoding="utf-8")
            for mark, value in values.items():
                words = words.replace(mark, value)
            (place / path.name.removesuffix(SUFFIX)).write_text(words, encoding="utf-8")
    except FileExistsError as problem:
        raise CommandError(f"{str(place)[:80]} exists already; choose another name, or remove it first.") from problem
    except OSError as problem:
        raise CommandError(f"{str(place)[:80]} cannot be written ({error_cause(problem)}); choose another folder.") from problem
