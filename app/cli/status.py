"""`status`: whether a server answers, and how busy it is."""

from __future__ import annotations

import argparse
import json
import sys
import urllib.error
import urllib.request

from .options import CommandError, add_json, cause

HELP = "ask a running server how it is"
PATIENCE = 5.0  # s
LONGEST = 10_000  # bytes of an answer that are read


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `status`."""
    parser.add_argument("url", nargs="?", default="http://127.0.0.1:8080",
                        help="address of the server (default %(default)s)")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print a line of figures; 1 if no Observer Lab answers there. Raises CommandError at an address that is none."""
    if not options.url.startswith(("http://", "https://")):
        raise CommandError(f"{options.url[:80]} is no address; give it with http:// or https://.")
    try:
        with urllib.request.urlopen(options.url.rstrip("/") + "/health", timeout=PATIENCE) as answer:
            health = json.loads(answer.read(LONGEST))
        line = "Observer Lab {version}: {tabs} of {most_tabs} tabs open, up {seconds:.0f} s".format(**health)
    except (OSError, ValueError, KeyError, TypeError) as problem:
        reason = problem.reason if isinstance(problem, urllib.error.URLError) else problem
        words = cause(reason if isinstance(reason, Exception) else problem)
        print(f"observer-lab: no Observer Lab answers at {options.url[:80]} ({words}).", file=sys.stderr)
        return 1
    print(json.dumps(health) if options.json else line)
    return 0
