"""Write a design as a link, with its QR code or as a file: `link`."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from ..options import PLANT_HELP, STATE_HELP, CommandError, add_json, add_language, add_own_lessons

if TYPE_CHECKING:
    from ...course.lesson import Lesson

HELP = "a link that opens a lesson exactly as you set it"


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `link`."""
    parser.add_argument("lesson", metavar="LESSON")
    add_own_lessons(parser)
    parser.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                        help="set a knob; may be repeated, and comes after --state")
    parser.add_argument("--state", metavar="TOKEN|FILE", help=STATE_HELP)
    parser.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    add_language(parser, "the page")
    parser.add_argument("--view", choices=("guide", "lab", "present"), help="how the lesson opens (default: that of --state, else lab)")
    parser.add_argument("--scene", metavar="ID", help="the scene of the guide that opens; without --state the knobs stand as on its entry")
    parser.add_argument("--print", action="store_true", dest="lecture", help="large print, as for a lecture")
    parser.add_argument("--at", metavar="ADDRESS", default="http://127.0.0.1:8080/",
                        help="where the server is reached (default %(default)s)")
    parser.add_argument("--qr", metavar="FILE", help="write the link as a QR code: .svg or .png")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the state as a file, which holds what a link cannot")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print the link; write what was asked for."""
    from ...course.scenes import entry_values
    from ...session.state.saved_state import write_state
    from ...session.state.token import write_token
    from ..inputs import changed, find_lesson, read_design, read_view
    from ..lesson_folder import lessons_of
    from ..outputs import save_code, save_words, write_whole_file
    from ..printing import print_json

    lessons = lessons_of(options)
    lesson = find_lesson(options.lesson, lessons)
    design = read_design(lesson, options.plant, options.state, options.changes, lessons)
    look = read_view(options.state, options.lang, lessons)
    look = replace(look, mode=options.view or look.mode, lecture=options.lecture or look.lecture or options.view == "present")
    if options.scene is not None:
        if options.view == "lab":
            raise CommandError("A scene belongs to the guide; give --scene with --view guide or present.")
        index = scene_index(lesson, options.scene, design.plant)
        if options.state is None:
            design = lesson.apply(read_design(lesson, options.plant, None, (), lessons), entry_values(lesson.path, index, lesson.start()))
            design = changed(lesson, design, options.changes)
        look = replace(look, scene=options.scene, mode=look.mode if look.mode == "present" else "guide", answered=None)
    saved = replace(look, design=design)
    token = write_token(lesson, saved)
    link = f"{options.at.partition('#')[0]}#{token}"
    if options.qr is not None:
        write_whole_file(options.qr, lambda path: save_code(link, path))
    if options.output is not None:
        write_whole_file(options.output, lambda path: save_words(write_state(lesson, saved), path))
    print_json({"link": link, "token": token}) if options.json else print(link)
    return 0


def scene_index(lesson: Lesson, scene: str, plant: str) -> int:
    """The place of a scene in the lesson's path. Raises CommandError naming those there are."""
    ids = [each.id for each in lesson.path]
    if plant:
        raise CommandError("The guide has no path for a plant of your own; leave out --scene or --plant.")
    if not ids:
        raise CommandError(f"Lesson {lesson.id} has no path of scenes; leave out --scene.")
    if scene not in ids:
        raise CommandError(f"Lesson {lesson.id} has no scene {scene[:40]}; it has {', '.join(ids)}.")
    return ids.index(scene)
