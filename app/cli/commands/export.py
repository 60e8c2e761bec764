"""Write a design as code, data, figures or a sheet for print: `export`."""

from __future__ import annotations

import argparse
from dataclasses import replace

from ..options import PLANT_HELP, STATE_HELP, CommandError, add_language, add_own_lessons, seconds
from ..records import add_record_options

HELP = "a design as a script that proves itself, as data, as figures or as a sheet for print"
SUFFIXES = (("python", ".py"), ("notebook", ".ipynb"), ("engine-notebook", "-engine.ipynb"), ("matlab", ".m"),
            ("json", ".json"), ("csv", ".csv"), ("estimates", "-estimates.csv"), ("pdf", ".pdf"), ("svg", ".svg"), ("png", ".png"))
FOLDERS = ("c", "arduino", "micropython", "fmu", "st", "simulink")  # kinds that are a folder of code for a device


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `export`."""
    parser.add_argument("lesson", metavar="LESSON")
    add_own_lessons(parser)
    parser.add_argument("--to", required=True, choices=[*(kind for kind, _ in SUFFIXES), *FOLDERS],
                        help="kind of file; engine-notebook uses the lab's own engine, "
                             "pdf is the sheet for print, svg and png show the figures on one page. Code for a device comes as a folder")
    add_language(parser, "scripts, figures and sheet")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to (default: the lesson's name in this folder)")
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                        help="set a knob; may be repeated, and comes after --state")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_record_options(parser)
    parser.add_argument("--ts", type=seconds, metavar="SECONDS", help="code for a device: its period (default: that of the page's run)")
    parser.add_argument("--part", metavar="NAME", help="code for a device: a part alone, as u1 of fault-diagnosis")
    parser.add_argument("--float", action="store_true", dest="single", help="code for a device: numbers of four bytes")
    parser.add_argument("--final", action="store_true", help="do the lesson's long computation too, if it has one")


def execute(options: argparse.Namespace) -> int:
    """Compute the design and write the file or folder; prints its name."""
    from ...course.knobs import KnobError
    from ...devices import DeviceError
    from ...engine import EngineError
    from ...export.data.data import json_text, save_csv, save_table
    from ...export.devices.folders import device_files
    from ...export.files import SCRIPTS, DownloadContent, FileError, sheet_file
    from ...export.scripts.matlab import function_name
    from ...export.scripts.script import ScriptError
    from ...session.state.token import write_token
    from ...study.points import outcome_of
    from ..inputs import find_lesson, fit_lesson, read_design, read_view
    from ..lesson_folder import lessons_of
    from ..outputs import save_bytes, save_page, save_words, write_folder, write_whole_file
    from ..records import from_record

    if options.to not in FOLDERS and (options.ts is not None or options.single or options.part is not None):
        raise CommandError(f"--ts, --float and --part are for code of a device; --to {options.to} has none of them.")
    lessons = lessons_of(options)
    origin = find_lesson(options.lesson, lessons)
    if options.data is not None:
        (lesson, design), look, token = from_record(origin, options), read_view(None, options.lang), ""  # no token can carry a record
    else:
        design = read_design(origin, options.plant, options.state, options.changes, lessons)
        look = read_view(options.state, options.lang, lessons)
        lesson, token = fit_lesson(origin, design.plant), write_token(origin, replace(look, design=design))
    called = function_name(origin) if options.to == "matlab" else origin.id
    name = options.output or f"{called}{dict(SUFFIXES).get(options.to, f'-{options.to}')}"
    try:
        outcome = outcome_of(lesson, design, options.final)
        if options.to in FOLDERS:
            write_folder(name, device_files(lesson, outcome, token, options.to, ts=options.ts, single=options.single,
                                            part=options.part))
            print(name)
            return 0
        if options.to in SCRIPTS:
            code = SCRIPTS[options.to][0](lesson, outcome, token, look.language)
            write_whole_file(name, lambda path: save_words(code, path))
        elif options.to == "json":
            write_whole_file(name, lambda path: save_words(json_text(design, outcome, token), path))
        elif options.to == "estimates":
            if lesson.estimates is None:
                raise CommandError(f"--to estimates is for lesson record; lesson {origin.id} has no such table.")
            table = lesson.estimates(outcome)
            write_whole_file(name, lambda path: save_table(table, path))
        elif options.to == "csv":
            write_whole_file(name, lambda path: save_csv(lesson.figures(outcome), path, token))
        elif not name.lower().endswith(dict(SUFFIXES)[options.to]):
            raise CommandError(f"{name[:80]} does not end in {dict(SUFFIXES)[options.to]}; name it so.")
        elif options.to == "pdf":
            file = sheet_file(DownloadContent(lesson, outcome, tuple(lesson.figures(outcome)), token, look.language))
            write_whole_file(name, lambda path: save_bytes(file.content, path))
        else:
            write_whole_file(name, lambda path: save_page(lesson.figures(outcome), path, look.language, token))
    except (EngineError, KnobError) as problem:
        raise CommandError(f"This design cannot be computed: {problem}") from problem
    except (FileError, ScriptError, DeviceError) as problem:
        raise CommandError(str(problem)) from problem
    print(name)
    return 0
