"""The command line: serve (default), list, run, verify.

Exit status 0: done; 1: a check failed; 2: bad usage or bad input, said in one sentence on stderr.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
from collections.abc import Sequence
from typing import NoReturn

COMMANDS = ("serve", "list", "run", "verify")
LANGUAGES = ("en", "zh")  # said here, so that a mistyped command is refused before anything heavy is imported
PLANT_HELP = "your own plant (.json or .mat), or the name of an example"
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class UsageError(Exception):
    """A command line that makes no sense; the message is one sentence."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message[:1].upper()}{message[1:]}; see {self.prog} --help.")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    for name in THREADS:
        os.environ.setdefault(name, "1")  # matrices of 20×20 are slower on several threads
    try:
        options = parser().parse_args(_with_command(list(sys.argv[1:] if argv is None else argv)))
        return _run(options)
    except UsageError as problem:
        print(f"observer-lab: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:  # whoever pressed Ctrl-C knows why
        return 128 + signal.SIGINT
    except BrokenPipeError:  # the reader of our output has gone, as with `| head`
        sys.stdout = None  # type: ignore[assignment]
        return 0


def _with_command(words: list[str]) -> list[str]:
    """`serve` is what is meant when no command is named."""
    if not words or (words[0].startswith("-") and words[0] not in ("-h", "--help")):
        return ["serve", *words]
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        raise UsageError(f"There is no command {words[0][:40]}; there are {', '.join(COMMANDS)}.")
    return words


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = _Parser("observer-lab", description="Control what you cannot fully see.", allow_abbrev=False)
    commands = top.add_subparsers(dest="command", metavar="{" + ",".join(COMMANDS) + "}", parser_class=_Parser)

    serve = commands.add_parser("serve", help="serve the lessons to browsers (default)", allow_abbrev=False)
    serve.add_argument("--host", default="127.0.0.1", help="address to listen on (default %(default)s)")
    serve.add_argument("--port", type=_port, default=8080, help="port, or the next free one; 0 for any (default %(default)s)")
    serve.add_argument("--lesson", metavar="ID", help="lesson that a page opens on")
    serve.add_argument("--lang", choices=LANGUAGES, default="en", help="language that a page opens in")
    serve.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    serve.add_argument("--public", action="store_true", help="yes, listen on an address that other machines can reach")
    serve.add_argument("--allow-host", action="append", default=[], type=_host, metavar="NAME", dest="names",
                       help="a name that people reach this server by, as that of a proxy; may be repeated")
    serve.add_argument("--max-sessions", type=_count, default=200, metavar="N", help="most tabs (default %(default)s)")

    listing = commands.add_parser("list", help="lessons, their knobs and tasks", allow_abbrev=False)
    listing.add_argument("--json", action="store_true", help="print JSON")

    run = commands.add_parser("run", help="compute a lesson without a browser", allow_abbrev=False)
    run.add_argument("lesson", metavar="LESSON")
    run.add_argument("--set", action="append", default=[], metavar="KNOB=VALUE", dest="changes",
                     help="set a knob; may be repeated, and comes after --state")
    run.add_argument("--state", metavar="FILE", help="start from a design that the app saved")
    run.add_argument("--plant", metavar="FILE", help=PLANT_HELP)
    run.add_argument("--final", action="store_true", help="do the lesson's long computation too, if it has one")
    run.add_argument("--figure", metavar="FILE", help="draw all figures on one page: .png, .svg or .pdf")
    run.add_argument("--csv", metavar="FILE", help="write the data of all figures")
    run.add_argument("--json", action="store_true", help="print JSON")

    verify = commands.add_parser("verify", help="every published number beside ours", allow_abbrev=False)
    verify.add_argument("--json", action="store_true", help="print JSON")
    return top


def _port(words: str) -> int:
    if not words.isascii() or not words.isdigit() or not 0 <= int(words[:9]) <= 65535:
        raise argparse.ArgumentTypeError(f"{words[:40]} is not a port; give a number from 1 to 65535, or 0 for a free one")
    return int(words)


def _host(words: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9_.-]{1,253}|[0-9A-Fa-f:.]{2,45}", words):
        raise argparse.ArgumentTypeError(f"{words[:40]} is not the name of a host; give it without http:// and without a port")
    return words


def _count(words: str) -> int:
    if not words.isascii() or not words.isdigit() or not 1 <= int(words[:9]) <= 100_000:
        raise argparse.ArgumentTypeError(f"{words[:40]} is not a number of tabs; give one from 1 to 100000")
    return int(words)


def _run(options: argparse.Namespace) -> int:
    from . import commands  # numpy is loaded only now, with its threads settled

    try:
        if options.command == "serve":
            from . import serve

            return serve.serve(serve.ServeRequest(options.host, options.port, options.lesson, options.lang,
                                                  options.max_sessions, options.plant, tuple(options.names),
                                                  options.public))
        if options.command == "list":
            return commands.list_lessons(options.json)
        if options.command == "verify":
            return commands.verify(options.json)
        request = commands.RunRequest(options.lesson, tuple(options.changes), options.state, options.final,
                                      options.figure, options.csv, options.plant)
        return commands.run(request, options.json)
    except commands.InputError as problem:
        raise UsageError(str(problem)) from problem
