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

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn
from urllib.parse import urlsplit

HEAD_KEYS = ("address", "key-file", "platforms")
PLATFORM_KEYS = ("issuer", "client-id", "login", "token", "key-set", "key-set-file", "deployments", "audience")
LOOPBACK = ("localhost", "127.0.0.1", "::1")
MAX_NAME_CHARACTERS = 255  # of an issuer, a client and a deployment, as the specification has it
MAX_ADDRESS_CHARACTERS = 500
ADDRESS = re.compile(r"https?://[\w.\[\]:-]+(?:/[^\s\"'<>;,]*)?(?:\?[^\s\"'<>;,]*)?", re.ASCII)


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
        data = tomllib.loads(words)
    except tomllib.TOMLDecodeError as problem:
        raise LtiFileError(f"it is not valid TOML: {str(problem)[:120]}") from problem
    _check_keys(data, HEAD_KEYS, "")
    tables = data.get("platforms")
    if not isinstance(tables, list) or not tables:
        _refuse("", "platforms", "is missing; write each platform under [[platforms]]")
    platforms = tuple(_platform(table, f"platform {number}, ", read_file) for number, table in enumerate(tables, 1))
    names = [(each.issuer, each.client_id) for each in platforms]
    if len(set(names)) < len(names):
        _refuse("", "platforms", "names the same issuer and client-id twice")
    return LtiSettings(_address(data, "address", ""), read_file(_text(data, "key-file", "")), platforms)


def _platform(table: object, where: str, read_file: Callable[[str], str]) -> Platform:
    if not isinstance(table, dict):
        _refuse("", "platforms", "must be tables, each under [[platforms]]")
    _check_keys(table, PLATFORM_KEYS, where)
    if ("key-set" in table) == ("key-set-file" in table):
        _refuse(where, "key-set", "or key-set-file must be given, one of the two")
    keys = _key_set(read_file(_text(table, "key-set-file", where)), where) if "key-set-file" in table else None
    deployments = table.get("deployments")
    if not isinstance(deployments, list) or not deployments or not all(_is_name(each) for each in deployments):
        _refuse(where, "deployments", 'must be a list of texts, as in ["1"]')
    token = _address(table, "token", where)
    return Platform(_text(table, "issuer", where), _text(table, "client-id", where), _address(table, "login", where), token,
                    "" if keys is not None else _address(table, "key-set", where), keys, frozenset(deployments),
                    _text(table, "audience", where) if "audience" in table else token)


def _key_set(words: str, where: str) -> Mapping[str, Any]:
    try:
        data = json.loads(words)
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict) or not isinstance(data.get("keys"), list) or not data["keys"]:
        _refuse(where, "key-set-file", 'must hold a key set, {"keys": [...]}')
    return data


def _text(table: Mapping[str, object], key: str, where: str) -> str:
    value = table.get(key)
    if not isinstance(value, str) or not _is_name(value):
        _refuse(where, key, f"must be a text of 1 to {MAX_NAME_CHARACTERS} characters")
    return value


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= MAX_NAME_CHARACTERS and value.isprintable()


def _address(table: Mapping[str, object], key: str, where: str) -> str:
    value = table.get(key)
    if not isinstance(value, str) or not is_web_address(value):
        _refuse(where, key, "must be an address that begins with https://, or one of this machine")
    return value


def _check_keys(table: Mapping[str, object], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            _refuse(where, str(key)[:40], f"is no key of this file; use {', '.join(known)}")


def _refuse(where: str, key: str, what: str) -> NoReturn:
    raise LtiFileError(f"{where}{key} {what}")
