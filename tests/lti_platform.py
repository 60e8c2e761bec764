"""A small learning platform for tests, written from the specification: logs in, signs launches, takes choices and points.

Sources: IMS Global, "Security Framework 1.0", "LTI Core Specification 1.3", "LTI Deep Linking 2.0", "Assignment and Grade Services 2.0".
It shares no code with the lab: tokens are put together by hand from `cryptography`.
"""

from __future__ import annotations

import base64
import http.client
import json
import secrets
import ssl
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import SplitResult, parse_qs, parse_qsl, urlencode, urljoin, urlsplit

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric import padding, rsa
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

CLAIM, DEEP = "https://purl.imsglobal.org/spec/lti/claim/", "https://purl.imsglobal.org/spec/lti-dl/claim/"
SERVICES, SCORE = "https://purl.imsglobal.org/spec/lti-ags/claim/endpoint", "https://purl.imsglobal.org/spec/lti-ags/scope/score"
ROLE = "http://purl.imsglobal.org/vocab/lis/v2/membership#"
CLIENT, DEPLOYMENT, KID = "lab-client", "7", "platform-key"
FORM = "application/x-www-form-urlencoded"


@lru_cache(maxsize=3)
def key_pair(name: str) -> rsa.RSAPrivateKey:
    """A key of that name, drawn once."""
    return rsa.generate_private_key(65537, 2048)


def pem(name: str) -> str:
    """That key as a file holds it."""
    return key_pair(name).private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption()).decode()


def b64(data: bytes) -> str:
    """Base64 for addresses, without padding."""
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def unb64(words: str) -> bytes:
    """What it stands for."""
    return base64.urlsafe_b64decode(words + "=" * (-len(words) % 4))


def number(value: int) -> str:
    """A whole number as a key set writes it."""
    return b64(value.to_bytes((value.bit_length() + 7) // 8, "big"))


def key_set(name: str = "platform") -> dict[str, Any]:
    """The public key set of a key."""
    public = key_pair(name).public_key().public_numbers()
    return {"keys": [{"kty": "RSA", "kid": KID, "alg": "RS256", "use": "sig", "n": number(public.n), "e": number(public.e)}]}


def joined(head: dict[str, Any], claims: dict[str, Any], sign: Callable[[bytes], bytes]) -> str:
    """A token with whatever signature."""
    words = ".".join(b64(json.dumps(part).encode()) for part in (head, claims))
    return f"{words}.{b64(sign(words.encode()))}"


def signed(claims: dict[str, Any], name: str = "platform", kid: str = KID) -> str:
    """A token with RS256."""
    return joined({"alg": "RS256", "kid": kid, "typ": "JWT"}, claims,
                  lambda words: key_pair(name).sign(words, padding.PKCS1v15(), SHA256()))


def checked(token: str, keys: dict[str, Any]) -> dict[str, Any]:
    """The claims of a token that one of the lab's public keys has signed. Raises InvalidSignature."""
    head, claims, signature = token.split(".")
    entry = next(key for key in keys["keys"] if key["kid"] == json.loads(unb64(head))["kid"])
    assert json.loads(unb64(head))["alg"] == "RS256" and "d" not in entry
    public = rsa.RSAPublicNumbers(int.from_bytes(unb64(entry["e"]), "big"), int.from_bytes(unb64(entry["n"]), "big")).public_key()
    public.verify(unb64(signature), f"{head}.{claims}".encode(), padding.PKCS1v15(), SHA256())
    return json.loads(unb64(claims))


@dataclass
class Answered:
    """An answer of the lab."""

    status: int
    text: str
    fields: list[tuple[str, str]]

    def field(self, name: str) -> str:
        """A field of its head; "" without it."""
        return next((value for given, value in self.fields if given.lower() == name.lower()), "")


class LearningBrowser:
    """A browser with cookies for one lab."""

    def __init__(self, lab: str) -> None:
        self.lab, self.cookies = lab, {}  # type: str, dict[str, str]

    def ask(self, path: str, form: dict[str, str] | bytes | None = None, kind: str = FORM, cookies: bool = True) -> Answered:
        """The answer to GET, or to POST of a form."""
        connection = self.connection(urlsplit(self.lab))
        head = {"Content-Type": kind} if form is not None else {}
        if cookies and self.cookies:
            head["Cookie"] = "; ".join(f"{name}={word}" for name, word in self.cookies.items())
        body = urlencode(form).encode() if isinstance(form, dict) else form
        connection.request("GET" if form is None else "POST", path, body, head)
        got = connection.getresponse()
        answer = Answered(got.status, got.read().decode(), got.getheaders())
        connection.close()
        for name, value in answer.fields:
            if name.lower() == "set-cookie":
                given, _, word = value.partition(";")[0].partition("=")
                if "max-age=0" in value.lower():
                    self.cookies.pop(given, None)
                else:
                    self.cookies[given] = word
        return answer

    def connection(self, place: SplitResult) -> http.client.HTTPConnection:
        """A new connection to the lab; over TLS any certificate will do."""
        if place.scheme == "https":
            return http.client.HTTPSConnection(place.hostname or "", place.port, timeout=20, context=ssl._create_unverified_context())
        return http.client.HTTPConnection(place.hostname or "", place.port, timeout=20)

    @property
    def cookie_line(self) -> str:
        """What the browser sends as Cookie."""
        return "; ".join(f"{name}={word}" for name, word in self.cookies.items())


@dataclass
class PlatformState:
    """What the platform has given and taken."""

    lab_keys: Callable[[], dict[str, Any]] = dict
    tokens: set[str] = field(default_factory=set)
    assertions: list[dict[str, Any]] = field(default_factory=list)
    scores: list[tuple[str, dict[str, Any]]] = field(default_factory=list)
    failures: int = 0  # so many posts of points are answered by 503 first
    key_sets_given: int = 0
    silent: threading.Event | None = None  # while it stands unset, who asks for the key set waits
    pages: dict[str, Callable[[dict[str, str]], str]] = field(default_factory=dict)  # by path: HTML from the fields of the address


class LearningPlatform:
    """The platform on a loopback port."""

    def __init__(self) -> None:
        self.state = state = PlatformState()

        class Handler(BaseHTTPRequestHandler):
            def log_message(self, *_: object) -> None:
                """Nothing."""

            def say(self, status: int, content: object) -> None:
                data = json.dumps(content).encode()
                self.send_response(status)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

            def do_GET(self) -> None:
                path, _, fields = self.path.partition("?")
                if path in state.pages:
                    self.send_response(200)
                    self.send_header("Content-Type", "text/html; charset=utf-8")
                    self.end_headers()
                    self.wfile.write(state.pages[path](dict(parse_qsl(fields))).encode())
                    return
                state.key_sets_given += 1
                if state.silent is not None:
                    state.silent.wait(60)
                self.say(200 if self.path == "/keys" else 404, key_set())

            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"])).decode()
                if self.path == "/token":
                    self.give_token(dict(parse_qsl(body)))
                elif state.failures > 0:
                    state.failures -= 1
                    self.say(503, {})
                elif self.headers.get("Authorization", "").removeprefix("Bearer ") not in state.tokens:
                    self.say(401, {})
                elif self.headers["Content-Type"] != "application/vnd.ims.lis.v1.score+json":
                    self.say(415, {})
                else:
                    state.scores.append((self.path, json.loads(body)))
                    self.say(200, {})

            def give_token(self, said: dict[str, str]) -> None:
                try:
                    claims = checked(said["client_assertion"], state.lab_keys())
                    address = f"http://{self.headers['Host']}/token"
                    assert said["grant_type"] == "client_credentials" and said["scope"] == SCORE
                    assert said["client_assertion_type"] == "urn:ietf:params:oauth:client-assertion-type:jwt-bearer"
                    assert claims["iss"] == claims["sub"] == CLIENT and claims["aud"] == address and claims["jti"]
                    assert claims["iat"] - 5 <= time.time() < claims["exp"] <= time.time() + 3600
                except (KeyError, AssertionError, InvalidSignature):
                    self.say(400, {"error": "invalid_client"})
                    return
                state.assertions.append(claims)
                token = secrets.token_urlsafe()
                state.tokens.add(token)
                self.say(200, {"access_token": token, "token_type": "Bearer", "expires_in": 3600, "scope": SCORE})

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def close(self) -> None:
        """End it."""
        self._server.shutdown()
        self._server.server_close()

    def toml(self, lab: str, key: str = "lab.pem", more: str = "") -> str:
        """The lab's file for this platform."""
        return (f'address = "{lab}/"\nkey-file = "{key}"\n\n'
                f'[[platforms]]\nissuer = "{self.url}"\nclient-id = "{CLIENT}"\n'
                f'login = "{self.url}/auth"\ntoken = "{self.url}/token"\nkey-set = "{self.url}/keys"\n'
                f'deployments = ["{DEPLOYMENT}"]\n{more}')

    def show_course(self, lab: str, lesson: str) -> str:
        """The address of a page of this platform with the lab's lesson, in a frame and behind a link; its login posts the launch."""
        begin = escape(f"{lab}/lti/login?" + urlencode({
            "iss": self.url, "login_hint": "hint-1", "target_link_uri": f"{lab}/lti/launch", "client_id": CLIENT}), quote=True)
        self.state.pages["/frame"] = lambda _: f'<!doctype html><title>Course</title><iframe src="{begin}" width=980 height=640></iframe>'
        self.state.pages["/link"] = lambda _: f'<!doctype html><title>Course</title><a href="{begin}">Lesson</a>'

        def auth(asked: dict[str, str]) -> str:
            form = {"id_token": signed(self.claims(asked, lesson=lesson)), "state": asked["state"]}
            fields = "".join(f'<input type="hidden" name="{name}" value="{value}">' for name, value in form.items())
            return (f'<!doctype html><form method="post" action="{escape(asked["redirect_uri"], quote=True)}">{fields}</form>'
                    "<script>document.forms[0].submit()</script>")
        self.state.pages["/auth"] = auth
        return self.url

    def trust(self, lab: str) -> None:
        """Take the lab's key set from where it stands."""
        def keys() -> dict[str, Any]:
            return json.loads(LearningBrowser(lab).ask("/lti/jwks").text)
        self.state.lab_keys = keys

    # --- launches --------------------------------------------------------------------------------------------------
    def begin(self, browser: LearningBrowser, post: bool = False, **changes: str) -> dict[str, str]:
        """Initiate a login; what the lab then asks the platform."""
        said = {"iss": self.url, "login_hint": "hint-1", "target_link_uri": f"{browser.lab}/lti/launch", "client_id": CLIENT,
                "lti_message_hint": "message-1", **changes}
        answer = browser.ask("/lti/login", said) if post else browser.ask(f"/lti/login?{urlencode(said)}")
        assert answer.status == 303, answer.text
        way = answer.field("Location")
        asked = dict(parse_qsl(urlsplit(way).query))
        assert way.startswith(f"{self.url}/auth?")
        assert {name: asked[name] for name in ("scope", "response_type", "response_mode", "prompt", "client_id", "login_hint",
                                               "lti_message_hint", "redirect_uri")} == {
            "scope": "openid", "response_type": "id_token", "response_mode": "form_post", "prompt": "none", "client_id": CLIENT,
            "login_hint": said["login_hint"], "lti_message_hint": "message-1", "redirect_uri": f"{browser.lab}/lti/launch"}
        return asked

    def claims(self, asked: dict[str, str], user: str = "user-1", lesson: str = "", **changes: Any) -> dict[str, Any]:
        """The claims of a launch; a change to None takes one away. Names of the specification without their beginning."""
        now = int(time.time())
        said = {"iss": self.url, "aud": CLIENT, "sub": user, "iat": now, "exp": now + 300, "nonce": asked["nonce"],
                "name": "Ada Lovelace", "email": "ada@example.org",
                f"{CLAIM}message_type": "LtiResourceLinkRequest", f"{CLAIM}version": "1.3.0", f"{CLAIM}deployment_id": DEPLOYMENT,
                f"{CLAIM}target_link_uri": asked["redirect_uri"], f"{CLAIM}resource_link": {"id": "link-1"},
                f"{CLAIM}roles": [f"{ROLE}Learner"],
                SERVICES: {"scope": [SCORE], "lineitem": f"{self.url}/items/1?kind=2"}}
        if lesson:
            said[f"{CLAIM}custom"] = {"lesson": lesson}
        for name, value in changes.items():
            full = next((key for key in said if key in (name, f"{CLAIM}{name}")), f"{CLAIM}{name}" if name == "custom" else name)
            said[full] = value
        return {name: value for name, value in said.items() if value is not None}

    def choice(self, asked: dict[str, str], **settings: Any) -> dict[str, Any]:
        """The claims of a launch that asks for a choice."""
        said = self.claims(asked, message_type="LtiDeepLinkingRequest", resource_link=None, roles=[f"{ROLE}Instructor"])
        said[f"{DEEP}deep_linking_settings"] = {"deep_link_return_url": f"{self.url}/return?course=4", "data": "opaque <data>",
                                                "accept_types": ["ltiResourceLink"],
                                                "accept_presentation_document_targets": ["iframe"], **settings}
        return said

    def launch(self, browser: LearningBrowser, lesson: str = "", user: str = "user-1", **changes: Any) -> Answered:
        """A whole launch."""
        asked = self.begin(browser)
        return browser.ask("/lti/launch", {"id_token": signed(self.claims(asked, user, lesson, **changes)), "state": asked["state"]})


def page_of(browser: LearningBrowser, answer: Answered) -> str:
    """The address of the page to which a launch goes, without what stands behind #."""
    return urljoin(f"{browser.lab}/lti/launch", answer.field("Location")).partition("#")[0]


def launch_id(page: str) -> str:
    """Which launch a page belongs to."""
    return parse_qs(urlsplit(page).query)["lti"][0]
