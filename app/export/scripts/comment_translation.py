"""Translate the comments of a script; the code stays as it is."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from ...text import text_in
from ...text.languages import translated

__all__ = ["CONTEXT", "comments_of", "script_header", "translate_comments"]

CONTEXT = "script"
COMMENT_PATTERNS: Mapping[str, tuple[re.Pattern[str], ...]] = MappingProxyType({  # what is before a comment, the comment, what is behind it
    "#": (re.compile(r'^(\s*""")(.+?)(""")$'), re.compile(r"^(\s*# (?:%% )?)(.+?)()$"), re.compile(r"^(.*\S  # )(.+?)()$")),
    "%": (re.compile(r"^(\s*%%? )(.+?)()$"), re.compile(r"^(.*\S  % )(.+?)()$"))})
TEMPLATES = (  # what a writer fills in
    text_in("script", "states {states}; inputs {inputs}; outputs {outputs}"),
    text_in("script", "The lesson also shows {names}; the run does not need them, and they are not computed here."),
    text_in("script", "s from one grid point to the next, and grid points; the run is cut where it diverges, at {time} s"),
    text_in("script", "The poles that the page calls '{name}' do not belong to this run's matrices; they are not computed here."),
    text_in("script", "'{name}' on the page: the eigenvalues of {matrix}"),
    text_in("script", "{unsaid}: the page shows them too, and they are not computed here."),
    text_in("script", "nothing is fed back by {gain} here"),
    text_in("script", "One input: the poles of {matrix} make {gain} unique (Ackermann)."),
    text_in("script", "One output: the poles of {matrix} make {gain} unique (Ackermann)."),
    text_in("script", "Several inputs: beside the poles s of {matrix} a direction g is free, here the page's."),
    text_in("script", "Several outputs: beside the poles s of {matrix} a direction g is free, here the page's."),
    text_in("script", "{gain} stands as the page found it: its poles (asserted below) and directions do not say it exactly enough."),
    text_in("script", "The poles make {gain} unique (Ackermann)."),
    text_in("script", "Several inputs: beside each pole a direction g is free, here the page's."),
    text_in("script", "Several outputs: beside each pole a direction g is free, here the page's."),
    text_in("script", "as the page found it: poles and directions do not say it exactly enough"),
    text_in("script", "nothing is fed back"),
    text_in("script", "the vertical channel alone: two balanced states"),
    text_in("script", "the rotation channel alone: two balanced states"),
    text_in("script", "the horizontal channel alone: two balanced states"))
PATTERNS = tuple((re.compile("^" + re.sub(r"\\\{(\w+)\\\}", r"(?P<\1>.+)", re.escape(one.id)) + "$"), one) for one in TEMPLATES)


def _said(comment: str, language: str) -> str:
    """One comment in a language, in English where it has none."""
    whole = translated(comment, CONTEXT, language)
    if whole != comment:
        return whole
    for pattern, template in PATTERNS:
        if found := pattern.match(comment):
            return template.format(**{name: translated(value, CONTEXT, language) for name, value in found.groupdict().items()})(language)
    return comment


def comments_of(body: str, mark: str) -> Iterator[str]:
    """What the comments of a text say, each as it stands; `mark` is "#" in Python and "%" in MATLAB."""
    for line in body.split("\n"):
        for pattern in COMMENT_PATTERNS[mark]:
            if found := pattern.match(line):
                yield found[2]
                break


def translate_comments(body: str, mark: str, language: str) -> str:
    """The text with its comments in a language, in English where the language has none."""
    if language == "en":
        return body
    lines = body.split("\n")
    for k, line in enumerate(lines):
        for pattern in COMMENT_PATTERNS[mark]:
            if found := pattern.match(line):
                lines[k] = found[1] + _said(found[2], language) + found[3]
                break
    return "\n".join(lines)


def script_header(token: str, mark: str, language: str) -> str:
    """The two lines at the head of every script: where it comes from, and what its signs are."""
    return "\n".join(f"{mark} {words(language)}" for words in (
        text_in("script", "Made by Observer Lab from the state {token}", token=token),
        text_in("script", "Every number stands in SI units. Signs: u = -K xhat, e = x - xhat, de/dt = (A - L C) e.")))
