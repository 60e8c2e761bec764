"""Read the file of `serve --lti`: the lab's own address and key, and the platforms that may open it.

    address = "https://lab.example.edu/"
    key-file = "lab.pem"

    [[platforms]]
    issuer = "https://moodle.example.edu"
    client-id = "aB3dE5"
    login = "https://moodle.example.edu/mod/lti/auth.php"
    token = "https://moodle.example.edu/mod/lti/token.php"
    key-set = "https://moodle.example.edu/mod/lti/certs.php"
    deployments = ["1"]

`key-set-file` names a file in the place of `key-set`; `audience` is whom a request for an access token addresses, `token` unless it is
given. Source: IMS Global, "Learning Tools Interoperability Core Specification 1.3" and "Security Framework 1.0".
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, NoReturn
from urllib.parse import urlsplit

import msgspec

from ...text import read_outside_json, read_outside_toml
from ...text.schema import Checked, Misfit, fitting, judge, says

LOOPBACK = ("localhost", "127.0.0.1", "::1")
MAX_NAME_CHARACTERS = 255  # of an issuer, a client and a deployment, as the specification has it
MAX_ADDRESS_CHARACTERS = 500
ADDRESS = re.compile(r"https?://[\w.\[\]:-]+(?:/[^\s\"'<>;,]*)?(?:\?[^\s\"'<>;,]*)?", re.ASCII)


DEPLOYMENTS = 'must be a list of texts, as in ["1"]'
ADDRESS_NEEDED = "must be an address that begins with https://, or one of this machine"
PRINTABLE = rf"^[^\x00-\x1f\x7f-\xa0\u2028\u2029]{{1,{MAX_NAME_CHARACTERS}}}\Z"
Name = Annotated[str, says(f"must be a text of 1 to {MAX_NAME_CHARACTERS} characters", pattern=PRINTABLE)]
Address = Annotated[str, says(ADDRESS_NEEDED)]


class _Platform(Checked, frozen=True, kw_only=True):
    issuer: Name
    client_id: Name
    login: Address
    token: Address
    key_set: Address | None = None
    key_set_file: Name | None = None
    deployments: Annotated[list[Annotated[str, says(DEPLOYMENTS, pattern=PRINTABLE)]], says(DEPLOYMENTS, min_length=1)]
    audience: Name | None = None


class _Head(Checked, frozen=True):
    address: Address
    key_file: Name
    platforms: Annotated[list[Annotated[_Platform, says("must be tables, each under [[platforms]]")]],
                         says("is missing; write each platform under [[platforms]]", min_length=1)]


class _KeySet(msgspec.Struct):
    keys: Annotated[list[Any], msgspec.Meta(min_length=1)]


class LtiFileError(ValueError):
    """A file of platforms that cannot be used; the message says in one sentence where and why."""


@dataclass(frozen=True)
class Platform:
    """A learning platform: how it is called, and where it logs in, gives tokens and shows its keys.

    `keys` is its key set where a file holds it, else None.
    """

    issuer: str
    client_id: str
    login: str
    token: str
    key_set: str
    keys: Mapping[str, Any] | None
    deployments: frozenset[str]
    audience: str


@dataclass(frozen=True)
class LtiSettings:
    """The lab's address as platforms know it, its private key, and the platforms."""

    address: str
    private_key: str = field(repr=False)
    platforms: tuple[Platform, ...]

    def platform(self, issuer: str, client_id: str | None) -> Platform | None:
        """The platform of that issuer and client; without a client, the only one of the issuer."""
        found = [each for each in self.platforms if each.issuer == issuer and client_id in (None, each.client_id)]
        return found[0] if len(found) == 1 else None


def is_web_address(words: object) -> bool:
    """Whether words are an address over TLS, or of this machine: nothing of a launch goes elsewhere in the clear."""
    if not isinstance(words, str) or len(words) > MAX_ADDRESS_CHARACTERS or ADDRESS.fullmatch(words) is None:
        return False
    try:
        parts = urlsplit(words)
        return bool(parts.hostname) and (parts.scheme == "https" or parts.hostname in LOOPBACK)
    except ValueError:
        return False


def read_settings(words: str, read_file: Callable[[str], str]) -> LtiSettings:
    """The settings of a TOML text; `read_file` reads a file that it names. Raises LtiFileError."""
    try:
        head = judge(read_outside_toml(words), _Head, "is no key of this file; use {keys}")
    except tomllib.TOMLDecodeError as problem:
        raise LtiFileError(f"it is not valid TOML: {str(problem)[:120]}") from problem
    except Misfit as problem:
        _refuse(f"platform {problem.place[1] + 1}, " if problem.place[1:] else "", problem.key, problem.words)  # type: ignore[operator]
    platforms = tuple(_platform(table, f"platform {number}, ", read_file) for number, table in enumerate(head.platforms, 1))
    if len({(each.issuer, each.client_id) for each in platforms}) < len(platforms):
        _refuse("", "platforms", "names the same issuer and client-id twice")
    return LtiSettings(_address(head.address, "address", ""), read_file(head.key_file), platforms)


def _platform(given: _Platform, where: str, read_file: Callable[[str], str]) -> Platform:
    if (given.key_set is None) == (given.key_set_file is None):
        _refuse(where, "key-set", "or key-set-file must be given, one of the two")
    keys = None if given.key_set_file is None else _key_set(read_file(given.key_set_file), where)
    login, token = _address(given.login, "login", where), _address(given.token, "token", where)
    return Platform(given.issuer, given.client_id, login, token, "" if keys is not None else _address(given.key_set, "key-set", where),
                    keys, frozenset(given.deployments), given.audience or token)


def _key_set(words: str, where: str) -> Mapping[str, Any]:
    try:
        data = read_outside_json(words)
    except ValueError:
        data = None
    if fitting(data, _KeySet) is None or not isinstance(data, dict):
        _refuse(where, "key-set-file", 'must hold a key set, {"keys": [...]}')
    return data


def _address(value: object, key: str, where: str) -> str:
    if not isinstance(value, str) or not is_web_address(value):
        _refuse(where, key, ADDRESS_NEEDED)
    return value


def _refuse(where: str, key: str, what: str) -> NoReturn:
    raise LtiFileError(f"{where}{key} {what}")
