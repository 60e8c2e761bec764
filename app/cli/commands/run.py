"""Compute and print a lesson's run without a browser: `run`."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace

from ..options import PLANT_HELP, STATE_HELP, CommandError, add_json, add_language, add_own_lessons
from ..records import add_record_options

HELP = "compute a lesson without a browser"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `run`."""
    parser.add_argument("lesson", metavar="LESSON")
    add_own_lessons(parser)
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                        help="set a knob; may be repeated, and comes after --state")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_record_options(parser)
    parser.add_argument("--final", action="store_true", help="do the lesson's long computation too, if it has one")
    parser.add_argument("--figure", metavar="FILE", help="draw all figures on one page: .png, .svg or .pdf")
    parser.add_argument("--csv", metavar="FILE", help="write the data of all figures")
    add_language(parser, "figures and sentences")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Compute a design, write what was asked for, print the run; 1 if one of the lesson's checks fails."""
    from ...course.knobs import KnobError
    from ...course.sentences import sentences
    from ...engine import EngineError
    from ...export.data.data import run_record, save_csv
    from ...session.state.token import write_token
    from ...study.points import outcome_of
    from ..inputs import find_lesson, fit_lesson, read_design, read_view
    from ..lesson_folder import lessons_of
    from ..outputs import save_page, write_whole_file
    from ..printing import print_json, print_run
    from ..records import from_record, print_record

    lessons = lessons_of(options)
    origin = find_lesson(options.lesson, lessons)
    if options.data is None:
        design = read_design(origin, options.plant, options.state, options.changes, lessons)
        look = read_view(options.state, options.lang, lessons)
        lesson, token = fit_lesson(origin, design.plant), write_token(origin, replace(look, design=design))
    else:
        (lesson, design), look, token = from_record(origin, options), read_view(None, options.lang), ""  # no token can carry a record
    try:
        outcome = outcome_of(lesson, design, options.final)
        figures = lesson.figures(outcome)
    except (EngineError, KnobError) as problem:
        raise CommandError(f"This design cannot be computed: {problem}") from problem
    if options.figure is not None:
        write_whole_file(options.figure, lambda path: save_page(figures, path, look.language, token))
    if options.csv is not None:
        write_whole_file(options.csv, lambda path: save_csv(figures, path, token))
    record = run_record(design, outcome)
    if options.json:
        print_json({**record, "sentences": [asdict(each) for each in sentences(lesson, outcome, look.language)]})
    else:
        print_run(lesson, record)
        if options.data is not None:
            print_record(outcome)
    return 0 if all(check.holds or check.informative for check in outcome.checks) else 1
