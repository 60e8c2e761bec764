"""Write a run as one page that plays without a server: `replay`."""

from __future__ import annotations

import argparse
from dataclasses import replace

from ..options import PLANT_HELP, STATE_HELP, CommandError, add_language

HELP = "a run as one page that plays in three dimensions without a server"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `replay`."""
    parser.add_argument("lesson", metavar="LESSON")
    parser.add_argument("-o", "--output", metavar="FILE.html", help="where to (default: the lesson's name in this folder)")
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                        help="set a knob; may be repeated, and comes after --state")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_language(parser, "the page")
    parser.add_argument("--dark", action="store_true", help="light letters on a dark ground")
    parser.add_argument("--final", action="store_true", help="do the lesson's long computation too, if it has one")


def execute(options: argparse.Namespace) -> int:
    """Compute the design and write the page; prints its name."""
    from ...course.knobs import KnobError
    from ...engine import EngineError
    from ...export.files import FileError
    from ...page.replay.replay import replay
    from ...session.state.token import write_token
    from ...session.state.view import Picture, State
    from ...study.points import outcome_of
    from ..inputs import find_lesson, fit_lesson, read_design, read_view
    from ..outputs import save_words, write_whole_file

    origin = find_lesson(options.lesson)
    design = read_design(origin, options.plant, options.state, options.changes)
    look = read_view(options.state, options.lang)
    lesson, name = fit_lesson(origin, design.plant), options.output or f"{origin.id}.html"
    if not name.lower().endswith((".html", ".htm")):
        raise CommandError(f"{name[:80]} does not end in .html; name it so.")
    try:
        outcome = outcome_of(lesson, design, options.final)
        state = State(language=look.language, dark=options.dark, camera=look.camera)
        page = replay(Picture(lesson, design, outcome, tuple(lesson.figures(outcome)), state, True),
                      write_token(origin, replace(look, design=design)))
    except (EngineError, KnobError) as problem:
        raise CommandError(f"This design cannot be computed: {problem}") from problem
    except FileError as problem:
        raise CommandError(str(problem)) from problem
    write_whole_file(name, lambda path: save_words(page, path))
    print(name)
    return 0
