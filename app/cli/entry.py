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
from types import MappingProxyType
from typing import Protocol

from .commands import exam, export, glossary, link, replay, run, serve, status, study, teach, verify
from .commands import list as list_
from .options import THREADS, CommandError, Parser


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
COMMANDS: Mapping[str, Command] = MappingProxyType({
    DEFAULT: serve, "list": list_, "teach": teach, "glossary": glossary, "exam": exam, "run": run, "link": link, "export": export,
    "replay": replay, "study": study, "verify": verify, "status": status})


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit status."""
    for name in THREADS:
        os.environ.setdefault(name, "1")  # matrices of 20×20 are slower on several threads
    try:
        options = parser().parse_args(_with_command(list(sys.argv[1:] if argv is None else argv)))
        return COMMANDS[options.command].execute(options)
    except CommandError as problem:
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
