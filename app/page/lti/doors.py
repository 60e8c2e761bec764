"""Answer at /lti/login, /lti/launch and /lti/jwks; tell a tab which student it has.

A login is answered by the way to the platform; a launch that the platform has signed for that login opens the lesson. All that lies
between two requests is sealed in the browser's cookies, so that any worker can answer.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import json
import logging
import secrets
from collections.abc import Callable, Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from urllib.parse import parse_qs, parse_qsl, urlencode

from websockets.http11 import Response

from ...course.handin.course_file import Course, CourseItem, Kind
from ...course.handin.grading import best_points, grade
from ...course.handin.learner import Learner, Report
from ...course.handin.ledger import KeptHandIns
from ...course.handin.served_course import ServedCourse
from ...course.lesson import Lesson
from ...course.scenes import Mode
from ...session.state.saved_state import SavedState
from ...session.state.token import write_token
from ..access.access_policy import Refusal, RequestHead, content_policy
from ..access.handshake import DoorRequest, plain_answer, text_answer
from ..words import phrases
from .browser_cookies import SealedCookies
from .deep_link import choice_page, form_origin, points_of
from .fetching import LtiRefused
from .key_sets import KeySets, KeysWantedError
from .keys import ToolKeys
from .launch import Launch, read_launch, verified_claims
from .scores import Scores
from .settings import LtiSettings, Platform

LOGIN, LAUNCH, KEY_SET = "/lti/login", "/lti/launch", "/lti/jwks"
FIELD = "lti"  # of the page's address: which launch of the browser a tab belongs to
MAX_FIELDS, MAX_THREADS = 30, 4
NOTHING_KEPT = Refusal(503, "This lab cannot keep logins at the moment; open the lesson again later.")
NO_LOGIN = "This launch answers no login of this browser; allow cookies, or open the lesson in a window of its own."

log = logging.getLogger(__name__)


class LtiDoors:
    """The doors of one server. `clock` gives seconds since 1970."""

    def __init__(self, settings: LtiSettings, keys: ToolKeys, ledger: KeptHandIns, lessons: Mapping[str, Lesson],
                 course: ServedCourse | None, port: int, clock: Callable[[], float], language: str = "en", mode: Mode = "lab",
                 scores: Scores | None = None) -> None:
        """A launch opens its lesson in `mode`, and in the guide where it names a scene."""
        self._settings, self._keys, self._ledger, self._clock = settings, keys, ledger, clock
        self._lessons, self._course, self._language = lessons, course, language
        self._mode: Mode = mode
        self._cookies = SealedCookies(keys, settings.address, port)
        self._threads = ThreadPoolExecutor(MAX_THREADS, "lti-door")  # no other part of the server waits for these, nor they for it
        self._key_sets, self._scores = KeySets(), scores or Scores(keys, clock)

    @property
    def paths(self) -> Collection[str]:
        """Where forms may be posted."""
        return (LOGIN, LAUNCH, KEY_SET)

    async def answer(self, request: DoorRequest) -> Response:
        """The answer to a request at one of them. It waits for a platform's keys without a thread, so that no other door waits."""
        if request.path.partition("?")[0] == KEY_SET:
            return text_answer(200, json.dumps(self._keys.key_set), "application/json")
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._threads, self._answer, request)
        except KeysWantedError as wanted:
            await self._key_sets.ask(wanted.platform)
            return await loop.run_in_executor(self._threads, self._answer, request)

    def _answer(self, request: DoorRequest) -> Response:
        """The answer of a door; a refusal is one sentence. Raises KeysWantedError."""
        path, _, question = request.path.partition("?")
        try:
            said = _fields(question) | _fields(request.form.decode("ascii", "replace"))
            return self._login(request, said) if path == LOGIN else self._launch(request, said)
        except LtiRefused as problem:
            log.warning("lti: %s", problem.refusal.words)
            return plain_answer(problem.refusal)
        except OSError:
            log.exception("lti: logins cannot be kept")
            return plain_answer(NOTHING_KEPT)

    # --- login and launch ------------------------------------------------------------------------------------------
    def _login(self, request: DoorRequest, said: Mapping[str, str]) -> Response:
        """The way to the platform's login, which answers at LAUNCH."""
        platform = self._settings.platform(said.get("iss", ""), said.get("client_id"))
        if platform is None:
            raise LtiRefused("This lab does not know this platform.")
        if not said.get("login_hint"):
            raise LtiRefused("The login names no user: its login_hint is missing.", 400)
        state, nonce = secrets.token_urlsafe(24), secrets.token_urlsafe(24)
        asked = {"scope": "openid", "response_type": "id_token", "response_mode": "form_post", "prompt": "none",
                 "client_id": platform.client_id, "redirect_uri": self._settings.address.rstrip("/") + LAUNCH,
                 "login_hint": said["login_hint"], "state": state, "nonce": nonce}
        if "lti_message_hint" in said:
            asked["lti_message_hint"] = said["lti_message_hint"]
        joint = "&" if "?" in platform.login else "?"
        kept = {"state": state, "nonce": nonce, "issuer": platform.issuer, "client": platform.client_id}
        return _go(f"{platform.login}{joint}{urlencode(asked)}", self._cookies.login(request.headers, state, kept))

    def _launch(self, request: DoorRequest, said: Mapping[str, str]) -> Response:
        """The lesson, or the page to choose one, for a launch that holds."""
        state, token = said.get("state", ""), said.get("id_token", "")
        if "error" in said:
            raise LtiRefused("The platform did not log this person in; open the lesson again in the learning platform.")
        if not state or not token:
            raise LtiRefused("A launch is opened by a learning platform; it has a state and an id_token.", 400)
        login = self._cookies.login_of(request.headers, state)
        if login is None or not hmac.compare_digest(str(login.get("state")).encode(), state.encode()):
            raise LtiRefused(NO_LOGIN)
        platform = self._settings.platform(str(login.get("issuer")), str(login.get("client")))
        if platform is None:
            raise LtiRefused("This lab does not know this platform.")
        nonce = str(login.get("nonce"))
        claims = verified_claims(token, platform, self._key_sets, nonce)
        launch = read_launch(platform, claims)
        if not self._ledger.use_nonce(nonce):
            raise LtiRefused("This launch was used before; open the lesson again in the learning platform.")
        end = self._cookies.without_login(state)
        return self._choose(request, launch, end) if launch.returns else self._open(request, launch, end)

    def _choose(self, request: DoorRequest, launch: Launch, end: str) -> Response:
        page = choice_page(launch, self._lessons, self._courses, self._language, self._settings.address, self._keys, int(self._clock()))
        answer = text_answer(200, page, "text/html; charset=utf-8")
        host = next(iter(request.headers.get_all("Host")), "")
        answer.headers["Content-Security-Policy"] = content_policy(host, request.frames, form_origin(launch.returns))
        answer.headers["Set-Cookie"] = end
        return answer

    def _open(self, request: DoorRequest, launch: Launch, end: str) -> Response:
        lesson = self._lessons.get(launch.lesson)
        if lesson is None and launch.lesson:
            raise LtiRefused("This lab has no lesson of the name that the launch asks for.", 404)
        if launch.scene and (lesson is None or launch.scene not in (scene.id for scene in lesson.path)):
            raise LtiRefused("The lesson has no scene of the name that the launch asks for.", 404)
        item = self._item(launch)
        cookies = [end, *([f"{request.cookie}; Path={self._cookies.path}"] if request.cookie else [])]
        query = ""
        if self._course is not None:
            names = (launch.platform.issuer, launch.platform.client_id, launch.deployment, launch.link, launch.user)
            id = hashlib.sha256("\n".join(names).encode("utf-8", "surrogatepass")).hexdigest()[:16]
            kept = {"issuer": launch.platform.issuer, "client": launch.platform.client_id, "user": launch.user,
                    "lineitem": launch.lineitem, "lesson": launch.lesson, "item": "" if item is None else item.name}
            cookies += self._cookies.launch(request.headers, id, kept)
            query = f"?{FIELD}={id}"
        return _go(f"../{query or './'}{'' if lesson is None else '#' + self._state(lesson, launch.scene)}", cookies)

    def _item(self, launch: Launch) -> CourseItem | None:
        """The exam or task that a launch opens, None where it opens a lesson. Raises LtiRefused."""
        kind: Kind = "exam" if launch.exam else "task"
        id = launch.exam or launch.task
        if not id:
            return None
        item = None if self._course is None else self._course.asked(kind, launch.lesson, id)
        if item is None:
            raise LtiRefused("The course of this lab has no exam or task of the name that the launch asks for.", 404)
        return item

    def _state(self, lesson: Lesson, scene: str) -> str:
        """The token by which a page opens the lesson at the scene; without one, in the lab where something is handed in."""
        items = () if self._courses is None else self._courses.items.values()
        handed_in = any(item.lesson == lesson.id and not item.practice for item in items)
        mode: Mode = "guide" if scene else "lab" if handed_in else self._mode
        return write_token(lesson, SavedState(lesson.start(), self._language, mode=mode, scene=scene))

    # --- the student of a tab --------------------------------------------------------------------------------------
    def learner(self, path: str, head: RequestHead) -> Learner | None:
        """Whom a tab belongs to, by its address and its browser's cookies; None where it was not launched, or too long ago."""
        asked = parse_qs(path.partition("?")[2]).get(FIELD, [])
        kept = self._cookies.launch_of(head, asked[0]) if asked else None
        platform = None if kept is None else self._settings.platform(str(kept["issuer"]), str(kept["client"]))
        if kept is None or platform is None or self._course is None:
            return None
        user, lineitem, lesson, item = str(kept["user"]), str(kept["lineitem"]), str(kept["lesson"]), str(kept.get("item", ""))
        student = self._course.course.keys.student(platform.issuer, user)
        return Learner(student, partial(self._report, platform, lineitem, user, lesson, item, student) if lineitem else None, item)

    def asked(self, path: str) -> bool:
        """Whether a tab says that it was launched."""
        return FIELD in parse_qs(path.partition("?")[2])

    def _report(self, platform: Platform, lineitem: str, user: str, lesson: str, item: str, student: str, token: str) -> Report:
        """Grade all that a student has handed in, and send the points: those of the item, of the lesson, or of all."""
        course = self._courses
        assert course is not None
        try:
            tokens, at = self._ledger.add(student, token, self._clock())
            findings = grade(course, self._lessons, [("", each) for each in tokens])
            points = best_points(course, findings).get(student, {})
            given = sum(worth for name, worth in points.items() if item in ("", name) and lesson in ("", course.items[name].lesson))
            most = course.items[item].points if item in course.items else points_of(course, lesson)
            self._scores.send(platform, lineitem, user, given, most, at)
        except LtiRefused as problem:
            log.warning("lti: points were not taken: %s", problem.refusal.words)
            return Report(phrases.POINTS_NOT_SENT, True)
        except Exception:
            log.exception("lti: points were not sent")
            return Report(phrases.POINTS_NOT_SENT, True)
        counts = any(one.token == token and one.refusal is None for one in findings)
        return Report(phrases.POINTS_SENT if counts else phrases.DOES_NOT_COUNT, not counts)

    @property
    def _courses(self) -> Course | None:
        return None if self._course is None else self._course.course


def _fields(words: str) -> dict[str, str]:
    """The fields of a question or a form, each once. Raises LtiRefused."""
    try:
        pairs = parse_qsl(words, keep_blank_values=True, max_num_fields=MAX_FIELDS)
    except ValueError as problem:
        raise LtiRefused("The request has too many fields.", 400) from problem
    if len(dict(pairs)) < len(pairs):
        raise LtiRefused("The request names a field twice.", 400)
    return dict(pairs)


def _go(address: str, cookies: Collection[str]) -> Response:
    answer = text_answer(303, "Go on there.", "text/plain; charset=utf-8")
    answer.headers["Location"] = address
    for cookie in cookies:
        answer.headers["Set-Cookie"] = cookie
    return answer
