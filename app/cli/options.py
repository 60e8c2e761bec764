"""Define what all commands share before heavy imports: error, parser, kinds of options."""

from __future__ import annotations

import argparse
import ipaddress
import math
import os
import re
from collections.abc import Callable
from typing import NoReturn

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")  # read when numpy is loaded
# name a Redis server in the environment, where no list of processes shows its password
ROOM_STORE, COURSE_STORE = "OBSERVER_LAB_ROOM_STORE", "OBSERVER_LAB_COURSE_STORE"
PLANT_HELP = "your own plant (.json or .mat), or the name of an example"
STATE_HELP = "begin with the state of a link, of its token, or of a file that the app saved"


class CommandError(Exception):
    """A command line that makes no sense, or input that a command cannot work with; the message is one sentence."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence, like all of ours."""

    def error(self, message: str) -> NoReturn:
        """Raises CommandError."""
        raise CommandError(f"{message[:1].upper()}{message[1:]}; see {self.prog} --help.")


def add_json(parser: argparse.ArgumentParser) -> None:
    """The option of every command that prints results."""
    parser.add_argument("--json", action="store_true", help="print JSON")


def add_language(parser: argparse.ArgumentParser, what: str) -> None:
    """The option of every command that writes words for people."""
    from ..text.languages import languages

    parser.add_argument("--lang", choices=languages(), help=f"language of {what} (default: that of --state, else en)")


def add_own_lessons(parser: argparse.ArgumentParser) -> None:
    """The options of every command that names a lesson, for lessons that are not of the course."""
    parser.add_argument("--lessons", metavar="FOLDER|ZIP", help="lessons of your own as well, one folder each; or a .zip of them")
    parser.add_argument("--trust-code", action="store_true", help="run the Python files of these lessons")


def whole_number(low: int, high: int, refusal: str) -> Callable[[str], int]:
    """The reader of an option that is a whole number from low to high; `refusal` follows what was given instead."""
    def read(words: str) -> int:
        if not words.isascii() or not words.isdigit() or not low <= int(words[:9]) <= high:
            raise argparse.ArgumentTypeError(f"{words[:40]} {refusal}")
        return int(words)
    return read


def seconds(words: str) -> float:
    """The reader of an option that is a period in seconds."""
    try:
        value = float(words)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{words[:40]} is no period; give a positive number of seconds")
    return value


def host_name(words: str) -> str:
    """The reader of an option that is a name or an address of a machine."""
    if not re.fullmatch(r"[A-Za-z0-9_.-]{1,253}|[0-9A-Fa-f:.]{2,45}", words):
        raise argparse.ArgumentTypeError(f"{words[:40]} is not the name of a host; give it without http:// and without "
                                         f"a port")
    return words


def allowed_host(words: str) -> str:
    """The reader of an option that is a name or an address of a machine, with a port or without."""
    name, colon, port = words.rpartition(":")
    bare = name[1:-1] if name.startswith("[") and name.endswith("]") else name
    if colon and re.fullmatch(r"\d{1,5}", port, re.ASCII) and 0 < int(port) <= 65535 and (bare != name or ":" not in name):
        host_name(bare)
        return words
    return host_name(words)


def network(words: str) -> str:
    """The reader of an option that is a network of addresses, or one address."""
    try:
        return str(ipaddress.ip_network(words.strip(), strict=False))
    except ValueError as problem:
        raise argparse.ArgumentTypeError(f"{words[:60]} is not a network; give it as in 10.0.0.0/8 or 2001:db8::/32") from problem


def web_address(words: str) -> str:
    """The reader of an option that is an address of a page."""
    if not re.fullmatch(r"https?://[A-Za-z0-9_.\[\]:-]{1,253}(?:/[\w.~/%-]{0,200})?", words, re.ASCII):
        raise argparse.ArgumentTypeError(f"{words[:60]} is not an address; give it as in https://lab.example.org/")
    return words


def redis_address(words: str) -> str:
    """The reader of an option that is the address of a Redis server. What is wrong is said without the address: it may hold a password."""
    if not re.fullmatch(r"rediss?://(?:[^\s/@]{0,300}@)?[A-Za-z0-9_.\[\]:-]{1,253}(?:/\d{0,4})?", words, re.ASCII):
        raise argparse.ArgumentTypeError("this is no address of a Redis server; give it as in redis://127.0.0.1:6379/0")
    return words


def stated_redis(given: str | None, variable: str) -> str | None:
    """The address of a Redis server from an option, else from a variable of the environment; None without both. Raises CommandError."""
    words = given or os.environ.get(variable)
    try:
        return None if words is None else redis_address(words)
    except argparse.ArgumentTypeError as problem:
        raise CommandError(str(problem)) from problem


def error_cause(problem: BaseException | None) -> str:
    """What went wrong, to stand in the middle of a sentence."""
    words = getattr(problem, "strerror", None) or str(problem) or type(problem).__name__
    return words[:1].lower() + words[1:].rstrip(".")
