"""Parse the command line and run one command; each command is a module.

Exit status 0: done; 1: a check failed; 2: bad usage or bad input, said in one sentence on stderr.
What is heavy is imported by `execute`, after the threads of numpy are settled and the command line makes sense.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType
from typing import Protocol

from .commands import (
    exam,
    export,
    find,
    glossary,
    grade,
    lecture_sheet,
    link,
    new_lesson,
    publish,
    replay,
    run,
    serve,
    sheet,
    status,
    study,
    teach,
    variant,
    verify,
)
from .commands import list as list_
from .live_plant import live
from .options import THREADS, CommandError, Parser, error_cause
from .terminal import give_up_output, set_up


class Command(Protocol):
    """What a command's module offers."""

    @property
    def HELP(self) -> str:
        """One line for the list of commands."""
        ...

    def arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the command's options."""

    def execute(self, options: argparse.Namespace) -> int:
        """Do it; the exit status. Raises CommandError."""
        ...


DEFAULT = "serve"
DEBUG = "OBSERVER_LAB_DEBUG"  # set in the environment: errors that nobody foresaw show where they arose
COMMANDS: Mapping[str, Command] = MappingProxyType({
    DEFAULT: serve, "list": list_, "teach": teach, "glossary": glossary, "find": find, "exam": exam, "variant": variant, "grade": grade,
    "run": run, "link": link, "live": live, "export": export,
    "replay": replay, "publish": publish, "study": study, "new-lesson": new_lesson,
    "verify": verify, "status": status, "sheet": sheet, "lecture-sheet": lecture_sheet})


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    for name in THREADS:
        os.environ.setdefault(name, "1")  # matrices of 20×20 are slower on several threads
    set_up()
    try:
        return _flushed(_execute(list(sys.argv[1:] if argv is None else argv)))
    except CommandError as problem:
        return _refuse(str(problem))
    except KeyboardInterrupt:  # whoever pressed Ctrl-C knows why
        return 128 + signal.SIGINT
    except BrokenPipeError:  # the reader of our output has gone, as with `| head`
        give_up_output()
        return 0
    except OSError as problem:
        if problem.filename is None:
            give_up_output()
            return _refuse(f"What is printed cannot be written ({error_cause(problem)}); make room, or send it elsewhere.")
        return _refuse(f"{str(problem.filename)[:80]} cannot be used ({error_cause(problem)}); choose another place.")
    except Exception as problem:
        if os.environ.get(DEBUG):
            raise
        return _refuse(_sentence(problem))


def _execute(words: list[str]) -> int:
    try:
        options = parser().parse_args(_with_command(words))
    except SystemExit:  # after --help
        _flushed(0)
        raise
    return COMMANDS[options.command].execute(options)


def _flushed(status: int) -> int:
    """The status, when all that was printed is written. Raises OSError where it cannot be."""
    if sys.stdout is not None:
        sys.stdout.flush()
    return status


def _refuse(sentence: str) -> int:
    with suppress(OSError):
        print(f"observer-lab: {sentence}", file=sys.stderr)
    return 2


def _sentence(problem: Exception) -> str:
    """What an error of the engine or of a lesson says; of an error that nobody foresaw, its kind."""
    from ..course.knobs import KnobError
    from ..engine import EngineError
    from ..session.runtime.error_words import error_kind

    if isinstance(problem, EngineError | KnobError):
        return f"This design cannot be computed: {problem}"
    return f"That could not be done ({error_kind(problem)}); change what was given, or set {DEBUG}=1 to see where it failed."


def _with_command(words: list[str]) -> list[str]:
    """`serve` is what is meant when no command is named."""
    if not words or (words[0].startswith("-") and words[0] not in ("-h", "--help")):
        return [DEFAULT, *words]
    if not words[0].startswith("-") and words[0] not in COMMANDS:
        raise CommandError(f"There is no command {words[0][:40]}; there are {', '.join(COMMANDS)}.")
    return words


def parser() -> argparse.ArgumentParser:
    """All commands and their options."""
    top = Parser("observer-lab", description="Control what you cannot fully see.", allow_abbrev=False)
    commands = top.add_subparsers(dest="command", metavar="{" + ",".join(COMMANDS) + "}", parser_class=Parser)
    for name, command in COMMANDS.items():
        command.arguments(commands.add_parser(name, help=command.HELP, allow_abbrev=False))
    return top
