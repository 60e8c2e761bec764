"""Verify the id_token of a launch and read what it opens.

Source: IMS Global, "Security Framework 1.0", section 5.1.3, and "LTI Core Specification 1.3", section 5.
"""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn
from urllib.parse import parse_qs, urlsplit

import jwt

from .fetching import LtiRefused
from .key_sets import KeySets
from .keys import ALGORITHM
from .settings import MAX_NAME_CHARACTERS, Platform, is_web_address

CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
DEEP_LINKING = "https://purl.imsglobal.org/spec/lti-dl/claim/"
SERVICES = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint"
SCORE_SCOPE = "https://purl.imsglobal.org/spec/lti-ags/scope/score"
RESOURCE_LINK, CHOICE = "LtiResourceLinkRequest", "LtiDeepLinkingRequest"
LINK_TYPE = "ltiResourceLink"
LEEWAY_S = 60  # s by which two clocks may differ
MAX_DATA_CHARACTERS = 8000  # of what a platform wants back from deep linking
SAID = (
    (jwt.ExpiredSignatureError, "The launch has expired; open the lesson again in the learning platform."),
    (jwt.ImmatureSignatureError, "The launch is dated in the future; the clocks of platform and lab differ."),
    (jwt.InvalidAudienceError, "The launch is meant for another tool."),
    (jwt.InvalidIssuerError, "The launch comes from another platform than the login."),
    (jwt.InvalidAlgorithmError, f"The launch must be signed with {ALGORITHM}."),
    (jwt.InvalidSignatureError, "The signature of the launch is not the platform's."),
    (jwt.MissingRequiredClaimError, "The launch lacks a claim that every launch has."),
)


@dataclass(frozen=True)
class Launch:
    """What a verified launch asks for. `lesson`, `scene`, `exam` and `task` are as they were said, "" where none was.

    `user` is the platform's number of a person; it goes back with points and is kept nowhere. `lineitem` is where the points of a learner
    go, "" where there is no such place. `returns` is where a choice goes, "" where none is asked for, `data` what goes back with it.
    """

    platform: Platform
    deployment: str
    user: str
    lesson: str = ""
    scene: str = ""
    link: str = ""
    lineitem: str = ""
    returns: str = ""
    data: str | None = None
    exam: str = ""
    task: str = ""


def verified_claims(token: str, platform: Platform, keys: KeySets, nonce: str) -> dict[str, Any]:
    """The claims of an id_token that this platform has signed for us, for this login, and that holds now. Raises LtiRefused."""
    try:
        head = jwt.get_unverified_header(token)
        if head.get("alg") != ALGORITHM:
            raise jwt.InvalidAlgorithmError
        claims = jwt.decode(token, keys.key(platform, head.get("kid")), algorithms=[ALGORITHM], audience=platform.client_id,
                            issuer=platform.issuer, leeway=LEEWAY_S, options={"require": ["iss", "aud", "exp", "iat", "nonce"]})
    except jwt.PyJWTError as problem:
        said = next((words for kind, words in SAID if isinstance(problem, kind)), "The launch holds no token that can be read.")
        raise LtiRefused(said) from problem
    audience = claims["aud"]
    if claims.get("azp", platform.client_id) != platform.client_id or (isinstance(audience, list) and len(audience) > 1
                                                                       and "azp" not in claims):
        raise LtiRefused("The launch is meant for another tool.")
    if not isinstance(claims["nonce"], str) or not hmac.compare_digest(claims["nonce"].encode(), nonce.encode()):
        raise LtiRefused("The launch does not answer the login of this browser.")
    return claims


def read_launch(platform: Platform, claims: Mapping[str, Any]) -> Launch:
    """What verified claims ask for. Raises LtiRefused where one is missing or unknown."""
    if claims.get(f"{CLAIM}version") != "1.3.0":
        _missing("version 1.3.0")
    deployment = _text(claims, f"{CLAIM}deployment_id", "deployment")
    if deployment not in platform.deployments:
        raise LtiRefused("This lab does not know the platform's deployment.")
    user = _text(claims, "sub", "user")
    roles = claims.get(f"{CLAIM}roles")
    if not isinstance(roles, list):
        _missing("roles")
    kind = claims.get(f"{CLAIM}message_type")
    if kind == CHOICE:
        return _choice(Launch(platform, deployment, user), claims)
    if kind != RESOURCE_LINK:
        raise LtiRefused("This lab does not know this kind of launch.")
    link = claims.get(f"{CLAIM}resource_link")
    target = _text(claims, f"{CLAIM}target_link_uri", "target", 2 * MAX_DATA_CHARACTERS)
    custom = claims.get(f"{CLAIM}custom")
    lesson, scene, exam, task = _place(target, custom if isinstance(custom, dict) else {})
    learns = any(isinstance(role, str) and role.rpartition("#")[2] == "Learner" for role in roles)
    return Launch(platform, deployment, user, lesson, scene, _text(link if isinstance(link, dict) else {}, "id", "resource link"),
                  _lineitem(claims.get(SERVICES)) if learns else "", exam=exam, task=task)


def _place(target: str, custom: Mapping[str, object]) -> list[str]:
    """Lesson, scene, exam and task by custom parameters, as deep linking sets them, or by the link's own question."""
    try:
        asked = parse_qs(urlsplit(target).query, max_num_fields=20)
    except ValueError:
        asked = {}
    said = [custom.get(name) or next(iter(asked.get(name, [])), "") for name in ("lesson", "scene", "exam", "task")]
    return [words if isinstance(words, str) else "" for words in said]


def _lineitem(services: object) -> str:
    """Where points go: the platform names the place, and lets us write there."""
    match services:
        case {"lineitem": str(lineitem), "scope": list(scopes)} if SCORE_SCOPE in scopes and is_web_address(lineitem):
            return lineitem
    return ""


def _choice(launch: Launch, claims: Mapping[str, Any]) -> Launch:
    match claims.get(f"{DEEP_LINKING}deep_linking_settings"):
        case {"deep_link_return_url": str(returns), "accept_types": list(kinds), **rest} if is_web_address(returns):
            if LINK_TYPE not in kinds:
                raise LtiRefused("The platform does not accept links to lessons here.")
            data = rest.get("data")
            if data is not None and not (isinstance(data, str) and len(data) <= MAX_DATA_CHARACTERS):
                raise LtiRefused("The platform's data for deep linking is too long.")
            return Launch(launch.platform, launch.deployment, launch.user, returns=returns, data=data)
    _missing("deep linking settings")


def _text(holder: Mapping[str, Any], key: str, called: str, longest: int = MAX_NAME_CHARACTERS) -> str:
    value = holder.get(key)
    if not isinstance(value, str) or not 0 < len(value) <= longest:
        _missing(called)
    return value


def _missing(what: str) -> NoReturn:
    raise LtiRefused(f"The launch does not name its {what}.")
