"""Ask a server whether it answers and how busy it is: `status`."""

from __future__ import annotations

import argparse
import ipaddress
import json
import os
import sys
import urllib.error
import urllib.request
from urllib.parse import parse_qs, urlsplit

from ..options import CommandError, add_json, error_cause

HELP = "ask a running server how it is"
ANSWER_TIMEOUT_S = 5.0  # s
MAX_ANSWER_BYTES = 10_000  # bytes of an answer that are read


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `status`."""
    parser.add_argument("url", nargs="?", default="http://127.0.0.1:8080",
                        help="address of the server, as it was printed (default %(default)s)")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Print a line of figures; 1 if no Observer Lab answers there. Raises CommandError at an address that is none."""
    if not options.url.startswith(("http://", "https://")):
        raise CommandError(f"{options.url[:80]} is no address; give it with http:// or https://.")
    from ...page.access.tokens import FIELD, VARIABLE

    url, _, asked = options.url.partition("?")
    _check(url)
    word = next(iter(parse_qs(asked).get(FIELD, [])), os.environ.get(VARIABLE, ""))
    question = urllib.request.Request(url.rstrip("/") + "/health", headers={"Authorization": f"Bearer {word}"} if word else {})
    try:
        with _opener(url).open(question, timeout=ANSWER_TIMEOUT_S) as answer:
            health = json.loads(answer.read(MAX_ANSWER_BYTES))
        line = "Observer Lab {version}: {tabs} of {most_tabs} tabs open, up {seconds:.0f} s".format(**health)
        line += "".join(map(_of_worker, health.get("workers", ())))
    except (OSError, ValueError, KeyError, TypeError) as problem:
        reason = problem.reason if isinstance(problem, urllib.error.URLError) else problem
        words = error_cause(reason if isinstance(reason, Exception) else problem)
        if isinstance(problem, urllib.error.HTTPError) and problem.code == 401:
            words = f"it asks for its access token; give the address with ?{FIELD}=…, or set {VARIABLE}"
        print(f"observer-lab: no Observer Lab answers at {url[:80]} ({words}).", file=sys.stderr)
        return 1
    print(json.dumps(health) if options.json else line)
    return 0


def _check(url: str) -> None:
    """Raises CommandError where the address cannot be one."""
    try:
        sound = bool(urlsplit(url).hostname) and url.isascii() and url.isprintable() and " " not in url and urlsplit(url).port != 0
    except ValueError:
        sound = False
    if not sound:
        raise CommandError(f"{url[:80]} is no address; give it as http://HOST:PORT.")


def _opener(url: str) -> urllib.request.OpenerDirector:
    """What opens an address: directly on this machine, through the proxy of the environment elsewhere."""
    host = urlsplit(url).hostname or ""
    try:
        here = host == "localhost" or host.endswith(".localhost") or ipaddress.ip_address(host).is_loopback
    except ValueError:
        here = False
    return urllib.request.build_opener(urllib.request.ProxyHandler({})) if here else urllib.request.build_opener()


def _of_worker(figures: dict[str, object]) -> str:
    line = "; worker {worker}: {tabs} open, up {seconds:.0f} s".format(**figures)
    return line + ("" if figures["starts"] == 1 else f" (start {figures['starts']})") + ("" if figures["stands"] else ", not standing")
