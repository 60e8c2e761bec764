"""The recipes for servers: no log holds a token, nothing is installed by a name that nobody owns, a course of 300 finds room."""

from __future__ import annotations

import json
import re
from pathlib import Path

from laws import each

from observer_lab.cli.entry import parser

DEPLOY = Path(__file__).parents[1] / "assets" / "deploy"
RECIPES = {path.name: path.read_text(encoding="utf-8") for path in DEPLOY.iterdir()}
NGINX = re.sub(r"#[^\n]*", "", RECIPES["nginx.conf"])
WITH_QUESTION = ("$request ", '$request"', "$request_uri", "$args", "$query_string", "$is_args", "$http_referer", "$arg_")
COURSE = 300  # students


def servers() -> list[str]:
    """The server blocks of the nginx recipe; a brace in them closes on its own line."""
    return [block.partition("\n}")[0] for block in NGINX.split("server {")[1:]]


def test_no_log_of_the_proxy_and_no_redirect_holds_what_stands_behind_the_question_mark() -> None:
    (words,) = re.findall(r"log_format\s+observer_lab\s+(.*?);", NGINX, re.DOTALL)
    assert not [name for name in WITH_QUESTION if name in words] and "$uri" in words
    for block in servers():
        logs = re.findall(r"access_log\s+([^;]+);", block)
        assert logs and all(log == "off" or log.endswith(" observer_lab") for log in logs)
        assert not re.findall(r"return\s[^;]*\$(?:request_uri|args|query_string)", block)
    assert re.search(r"error_log\s+\S+\s+crit;", servers()[1]), "lower levels write the whole address"


def test_the_proxy_keeps_browsers_on_tls_and_says_who_comes() -> None:
    assert re.search(r'add_header Strict-Transport-Security "max-age=\d{7,}" always;', servers()[1])
    for field in ("X-Forwarded-For $proxy_add_x_forwarded_for", "X-Forwarded-Proto $scheme", "Host $http_host", "Upgrade $http_upgrade"):
        assert f"proxy_set_header {field};" in servers()[1]


@each("name", list(RECIPES))
def test_no_recipe_installs_by_a_name_that_nobody_owns(name: str) -> None:
    for words in re.findall(r"pip install([^\n`|]*)", RECIPES[name]):
        assert not re.search(r"(?<![\w./*-])observer[-_]lab(?![\w*.-])", words.partition("&&")[0]), words


@each("name", ["observer-lab.service", "Containerfile"])
def test_a_course_finds_room(name: str) -> None:
    (most,) = re.findall(r'--max-sessions"?,? "?(\d+)', RECIPES[name])
    assert int(most) >= COURSE


def commands() -> dict[str, list[str]]:
    """The command line by which each recipe starts the lab."""
    (unit,) = re.findall(r"^ExecStart=\S+/observer-lab (.*)$", RECIPES["observer-lab.service"], re.MULTILINE)
    (entry,) = re.findall(r"^ENTRYPOINT (\[.*\])$", RECIPES["Containerfile"], re.MULTILINE)
    (check,) = re.findall(r"CMD (\[.*\])$", RECIPES["Containerfile"], re.MULTILINE)
    return {"unit": unit.split(), "container": json.loads(entry)[1:], "check": json.loads(check)[1:]}


@each("name", ["unit", "container", "check"])
def test_the_command_of_a_recipe_is_one_that_the_program_takes(name: str) -> None:
    words = commands()[name]
    assert parser().parse_args(words).command == words[0]


def test_the_unit_is_hardened_and_may_raise_its_own_limits() -> None:
    """`systemd-analyze security --offline=true` gives 1.4; the lab calls setrlimit, which a denied @resources would end."""
    unit = RECIPES["observer-lab.service"]
    for line in ("CapabilityBoundingSet=", "PrivateUsers=yes", "ProtectProc=invisible", "RestrictNamespaces=yes", "UMask=0077",
                 "ProtectKernelLogs=yes", "ProtectClock=yes", "SystemCallFilter=~@privileged"):
        assert f"\n{line}\n" in unit, line
    assert "@resources" not in re.sub(r"#[^\n]*", "", unit)
