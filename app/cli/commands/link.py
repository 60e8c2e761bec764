"""Write a design as a link, with its QR code or as a file: `link`."""

from __future__ import annotations

import argparse
from dataclasses import replace

from ..options import PLANT_HELP, STATE_HELP, add_json, add_language

HELP = "a link that opens a lesson exactly as you set it"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `link`."""
    parser.add_argument("lesson", metavar="LESSON")
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                        help="set a knob; may be repeated, and comes after --state")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_language(parser, "the page")
    parser.add_argument("--print", action="store_true", dest="lecture", help="large print, as for a lecture")
    parser.add_argument("--at", metavar="ADDRESS", default="http://127.0.0.1:8080/",
                        help="where the server is reached (default %(default)s)")
    parser.add_argument("--qr", metavar="FILE", help="write the link as a QR code: .svg or .png")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the state as a file, which holds what a link cannot")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print the link; write what was asked for."""
    from ...session.state.saved_state import write_state
    from ...session.state.token import write_token
    from ..inputs import find_lesson, read_design, read_view
    from ..outputs import save_code, save_words, write_whole_file
    from ..printing import print_json

    lesson = find_lesson(options.lesson)
    design, look = read_design(lesson, options.plant, options.state, options.changes), read_view(options.state, options.lang)
    saved = replace(look, design=design, lecture=options.lecture or look.lecture)
    token = write_token(lesson, saved)
    link = f"{options.at.partition('#')[0]}#{token}"
    if options.qr is not None:
        write_whole_file(options.qr, lambda path: save_code(link, path))
    if options.output is not None:
        write_whole_file(options.output, lambda path: save_words(write_state(lesson, saved), path))
    print_json({"link": link, "token": token}) if options.json else print(link)
    return 0
