"""A platform written from the specification opens lessons, chooses one and gets points; hostile launches open nothing."""

from __future__ import annotations

import hmac
import http.client
import json
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from html import unescape
from pathlib import Path
from typing import Any
from urllib.parse import urlencode, urlsplit

import pytest
from client import WireTab
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from lti_platform import (
    CLAIM,
    CLIENT,
    DEEP,
    KID,
    Answered,
    LearningBrowser,
    LearningPlatform,
    checked,
    joined,
    key_pair,
    launch_id,
    page_of,
    pem,
    signed,
)

from observer_lab.course.handin.course_file import read_course
from observer_lab.course.handin.hand_in import read_hand_in
from observer_lab.course.handin.learner import Report
from observer_lab.course.handin.ledger import FILE, Ledger
from observer_lab.course.handin.served_course import ServedCourse, student_item
from observer_lab.lessons import LESSONS
from observer_lab.page.access.access_policy import RequestHead
from observer_lab.page.access.addresses import listen
from observer_lab.page.access.request_head import MAX_FORM_BYTES
from observer_lab.page.access.tokens import AccessToken
from observer_lab.page.lti.browser_cookies import MAX_LAUNCHES, MAX_LOGINS
from observer_lab.page.lti.doors import LtiDoors
from observer_lab.page.lti.keys import ToolKeys
from observer_lab.page.lti.scores import Scores
from observer_lab.page.lti.settings import read_settings
from observer_lab.page.screen.server import LabServer
from observer_lab.page.words import phrases
from observer_lab.session.commands.commands import OpenLesson
from observer_lab.session.handlers.exams import PLATFORM_DECIDES
from observer_lab.session.state.token import read_token

WORD, FRAME = "the-word-of-this-lab", "moodle.example.edu"
EXAM, OTHER = LESSONS["kalman"].exams[:2]
COURSE = read_course('course = "filters"\ntitle = "Filters"\nsecret = "a secret of a course, for tests alone"\ntries = 2\npoints = 5\n'
                     f'[[lessons]]\nlesson = "kalman"\nexams = ["{EXAM.id}", "{OTHER.id}"]\n'
                     '[[lessons]]\nlesson = "separation"\ntasks = "all"\nmode = "practice"\n', LESSONS, str)


@dataclass
class Lab:
    """A lab that one platform may open."""

    server: LabServer
    platform: LearningPlatform
    folder: Path

    @property
    def url(self) -> str:
        return self.server.url

    def browser(self) -> LearningBrowser:
        return LearningBrowser(self.url)

    def tab(self, browser: LearningBrowser, answer: Answered) -> WireTab:
        """The tab that a launch opens."""
        place = urlsplit(page_of(browser, answer))
        tab = WireTab(self.url, path=f"/?{place.query}", cookies=browser.cookie_line)
        tab.settle()
        return tab


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder, platform = tmp_path_factory.mktemp("lti"), LearningPlatform()
    listener = listen("127.0.0.1", 0)
    port = listener.getsockname()[1]
    settings = read_settings(platform.toml(f"http://127.0.0.1:{port}"), lambda name: pem("lab"))
    keys = ToolKeys(settings.private_key)
    doors = LtiDoors(settings, keys, Ledger(folder), LESSONS, ServedCourse(COURSE, time.time), port, time.time,
                     scores=Scores(keys, time.time, lambda _: None))
    server = LabServer(LESSONS, listener=listener, lesson="separation", access=AccessToken(WORD, port), frames=(FRAME,), sealed=True,
                       course=ServedCourse(COURSE, time.time), doors=doors)
    platform.trust(server.url)
    yield Lab(server, platform, folder)
    server.stop()
    platform.close()


def right(student: str) -> str:
    return EXAM.digits.written(student_item(COURSE, student, "kalman", EXAM).answer)


def hand_in(tab: WireTab, answer: str, sentence: str) -> None:
    told = len(tab.notes)
    tab.update("answer", value=answer)
    tab.press("hand in")
    tab.until(lambda: sentence in tab.notes[told:], sentence)


# --- what must work ----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("post", [False, True])
def test_a_launch_opens_its_lesson_for_a_browser_that_did_not_know_the_word(lab: Lab, post: bool) -> None:
    browser = lab.browser()
    assert browser.ask("/").status == 401
    asked = lab.platform.begin(browser, post=post)
    answer = browser.ask("/lti/launch", {"id_token": signed(lab.platform.claims(asked, lesson="kalman")), "state": asked["state"]})
    assert answer.status == 303, answer.text
    token = answer.field("Location").partition("#")[2]
    assert read_token(token, LESSONS).design.lesson == "kalman"
    flags = [value for name, value in answer.fields if name.lower() == "set-cookie"]
    assert all("SameSite=None; Secure; Partitioned" in value and "HttpOnly" in value and "Path=/" in value for value in flags)
    page = browser.ask(f"/?{urlsplit(page_of(browser, answer)).query}")
    assert page.status == 200 and f"frame-ancestors https://{FRAME}" in page.field("Content-Security-Policy")
    assert not any("login" in name for name in browser.cookies), "the login is over"


def test_a_launch_opens_a_scene_and_the_link_itself_may_name_the_lesson(lab: Lab) -> None:
    scene = LESSONS["kalman"].path[2].id
    question = urlencode({"lesson": "kalman", "scene": scene})
    for changes in ({"custom": {"lesson": "kalman", "scene": scene}}, {"target_link_uri": f"{lab.url}/lti/launch?{question}"}):
        answer = lab.platform.launch(lab.browser(), **changes)
        assert answer.status == 303, answer.text
        state = read_token(answer.field("Location").partition("#")[2], LESSONS)
        assert (state.design.lesson, state.scene, state.mode) == ("kalman", scene, "guide")


def test_a_launch_without_a_lesson_opens_the_course(lab: Lab) -> None:
    answer = lab.platform.launch(lab.browser())
    assert answer.status == 303 and answer.field("Location").startswith("../?lti=") and "#" not in answer.field("Location")


def test_the_key_set_is_public_and_holds_no_secret(lab: Lab) -> None:
    answer = lab.browser().ask("/lti/jwks")
    (key,) = json.loads(answer.text)["keys"]
    assert answer.status == 200 and key["kty"] == "RSA" and not {"d", "p", "q", "dp", "dq", "qi"} & set(key)


def test_a_teacher_chooses_a_lesson_and_the_platform_gets_it_signed(lab: Lab) -> None:
    browser, platform = lab.browser(), lab.platform
    asked = platform.begin(browser)
    answer = browser.ask("/lti/launch", {"id_token": signed(platform.choice(asked)), "state": asked["state"]})
    assert answer.status == 200, answer.text
    policy = answer.field("Content-Security-Policy")
    assert f"form-action {platform.url};" in policy and f"frame-ancestors https://{FRAME}" in policy
    assert f'action="{platform.url}/return?course=4"' in answer.text and "<script" not in answer.text
    keys = platform.state.lab_keys()
    chosen = {}
    for token, title in re.findall(r'<button name="JWT" value="([^"]+)">([^<]+)</button>', answer.text):
        claims = checked(token, keys)
        assert (claims["iss"], claims["aud"]) == (CLIENT, platform.url) and claims["exp"] > time.time() and claims["nonce"]
        assert claims[f"{CLAIM}message_type"] == "LtiDeepLinkingResponse" and claims[f"{CLAIM}version"] == "1.3.0"
        assert claims[f"{CLAIM}deployment_id"] == "7" and claims[f"{DEEP}data"] == "opaque <data>"
        (item,) = claims[f"{DEEP}content_items"]
        assert item["type"] == "ltiResourceLink" and item["title"] == unescape(title)
        if "exam" not in item.get("custom", {}):
            chosen[item.get("custom", {}).get("lesson", "")] = item
    assert set(chosen) == {"", *LESSONS}
    items = [claims[f"{DEEP}content_items"][0] for token in re.findall(r'name="JWT" value="([^"]+)"', answer.text)
             if "exam" in (claims := checked(token, keys))[f"{DEEP}content_items"][0].get("custom", {})]
    assert [item["custom"] for item in items] == [{"lesson": "kalman", "exam": exam.id} for exam in (EXAM, OTHER)]
    assert all(item["lineItem"]["scoreMaximum"] == 5 and item["url"].endswith(f"exam={item['custom']['exam']}") for item in items)
    assert chosen["kalman"]["lineItem"]["scoreMaximum"] == 10 and "lineItem" not in chosen["separation"]
    opened = platform.launch(lab.browser(), target_link_uri=chosen["kalman"]["url"])
    assert read_token(opened.field("Location").partition("#")[2], LESSONS).design.lesson == "kalman"


def test_a_launch_of_an_exam_opens_it_alone_and_sends_its_points(lab: Lab) -> None:
    platform, browser, user = lab.platform, lab.browser(), "user-of-one-exam"
    student = COURSE.keys.student(platform.url, user)
    platform.state.scores.clear()
    answer = platform.launch(browser, "", user, custom={"lesson": "kalman", "exam": EXAM.id})
    state = read_token(answer.field("Location").partition("#")[2], LESSONS)
    assert (state.design.lesson, state.mode) == ("kalman", "lab")
    with lab.tab(browser, answer) as tab:
        lab.server.sessions[max(lab.server.sessions)].post(OpenLesson("kalman"))
        tab.until(lambda: tab.has("hand in"), "the exam")
        tab.answered()
        assert tab.labels("answer") == 1 and tab.labels("hand in") == 1 and not tab.has("result")
        title = LESSONS["kalman"].words["en"].exams[EXAM.id].title
        opened = {w["props"]["label"]: w["props"]["expand_by_default"] for w in tab.widgets.values() if w["type"] == "GuiFolderMessage"}
        assert opened[phrases.EXAM("en")] and opened[f"1 {title}"], opened
        hand_in(tab, right(student), phrases.POINTS_SENT("en"))
    assert [(score["scoreGiven"], score["scoreMaximum"]) for _, score in platform.state.scores] == [(5, 5)]
    for custom in ({"lesson": "kalman", "exam": "none"}, {"lesson": "separation", "task": "none"}, {"lesson": "kalman", "task": "filter"}):
        assert platform.launch(lab.browser(), "", user, custom=custom).status == 404


def test_points_of_a_hand_in_reach_the_line_item_and_nothing_personal_is_kept(lab: Lab) -> None:
    platform, browser = lab.platform, lab.browser()
    user = "user-with-points"
    student = COURSE.keys.student(platform.url, user)
    platform.state.scores.clear()
    answer = platform.launch(browser, "kalman", user)
    with lab.tab(browser, answer) as tab:
        session = lab.server.sessions[max(lab.server.sessions)]
        session.post(OpenLesson("kalman"))
        tab.until(lambda: tab.has("hand in"), "the exam")
        assert session.picture is not None and session.picture.state.key == student
        tab.answered()
        hand_in(tab, "12345.678", phrases.POINTS_SENT("en"))
        hand_in(tab, right(student), phrases.POINTS_SENT("en"))
        hand_in(tab, "0.98765", phrases.DOES_NOT_COUNT("en"))
        tab.update("your key", value="another")
        tab.until(lambda: PLATFORM_DECIDES("en") in tab.notes, "a refusal")
        said = repr(tab.messages)
    posted = platform.state.scores
    assert [path for path, _ in posted] == ["/items/1/scores?kind=2"] * 3
    assert [score["scoreGiven"] for _, score in posted] == [0, 5, 5]
    for _, score in posted:
        assert score["scoreMaximum"] == 10 and score["userId"] == user and score["gradingProgress"] == "FullyGraded"
        assert score["activityProgress"] == "Submitted"
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+00:00", score["timestamp"])
    assert len({score["timestamp"] for _, score in posted}) == 3 and len(platform.state.assertions) == 1, "one token for all"
    kept = b"".join(path.read_bytes() for path in lab.folder.iterdir())
    assert student.encode() in kept and (lab.folder / FILE).stat().st_mode & 0o077 == 0
    for person in (user, "Lovelace", "ada@example.org"):
        assert person.encode() not in kept and person not in said
    assert all(read_hand_in(COURSE, token).student == student for token in re.findall(r"olh1\.[\w-]+\.[\w-]+", said))


def test_a_platform_that_fails_twice_gets_the_points_and_one_that_is_down_costs_one_sentence(lab: Lab) -> None:
    platform, browser = lab.platform, lab.browser()
    platform.state.scores.clear()
    learner = _learner(lab, browser, platform.launch(browser, "kalman", "patient"))
    assert learner is not None and learner.report is not None
    platform.state.failures = 2
    assert learner.report("no token").words("en") != phrases.POINTS_NOT_SENT("en") and len(platform.state.scores) == 1
    platform.state.failures = 3
    report = learner.report("no token")
    assert report.bad and report.words("en") == phrases.POINTS_NOT_SENT("en") and len(platform.state.scores) == 1


def test_points_that_are_overtaken_take_nothing_back_and_tries_count_as_they_came(lab: Lab) -> None:
    """Two workers, a clock that stands still, and a platform that fails the first: its points arrive behind those of the second."""
    browser, platform, now, user = lab.browser(), lab.platform, time.time(), "user-in-a-hurry"
    page, reports = page_of(browser, platform.launch(browser, "kalman", user)), list[Report]()
    settings = read_settings(platform.toml(lab.url), lambda name: pem("lab"))
    keys, served = ToolKeys(settings.private_key), ServedCourse(COURSE, lambda: now)

    def worker(wait: Callable[[float], object]) -> Callable[[str], Report]:
        doors = LtiDoors(settings, keys, Ledger(lab.folder), LESSONS, served, int(lab.url.rpartition(":")[2]), lambda: now,
                         scores=Scores(keys, lambda: now, wait))
        learner = doors.learner(page, cookies_of(browser))
        assert learner is not None and learner.report is not None
        return learner.report
    student, item = COURSE.keys.student(platform.url, user), COURSE.items[f"kalman exam {EXAM.id}"]
    wrong, good, late = (served.hand_in(item, student, answer) for answer in ("12345.678", right(student), "0.98765"))
    platform.state.scores.clear()
    platform.state.failures = 1
    other = worker(lambda _: None)
    reports.append(worker(lambda _: reports.append(other(good)))(wrong))
    reports.append(other(late))
    assert [report.words for report in reports] == [phrases.POINTS_SENT, phrases.POINTS_SENT, phrases.DOES_NOT_COUNT]
    posted = [(score["timestamp"], score["scoreGiven"]) for _, score in platform.state.scores]
    assert [given for _, given in posted] == [5, 0, 5] and posted[1][0] < posted[0][0] < posted[2][0], posted


@pytest.mark.parametrize("changes", [
    {"roles": ["http://purl.imsglobal.org/vocab/lis/v2/membership#Instructor"]},
    {"https://purl.imsglobal.org/spec/lti-ags/claim/endpoint": None},
    {"https://purl.imsglobal.org/spec/lti-ags/claim/endpoint": {"scope": [], "lineitem": "https://lms.example/1"}},
    {"https://purl.imsglobal.org/spec/lti-ags/claim/endpoint": {
        "scope": ["https://purl.imsglobal.org/spec/lti-ags/scope/score"], "lineitem": "http://lms.example/1"}},
], ids=["teacher", "no service", "no right", "not over TLS"])
def test_no_points_are_sent_where_there_is_no_place_for_them(lab: Lab, changes: dict[str, Any]) -> None:
    browser = lab.browser()
    learner = _learner(lab, browser, lab.platform.launch(browser, "kalman", **changes))
    assert learner is not None and learner.report is None


def cookies_of(browser: LearningBrowser) -> RequestHead:
    class Head:
        def get_all(self, key: str) -> list[str]:
            return [browser.cookie_line] if key == "Cookie" else []
    return Head()


def _learner(lab: Lab, browser: LearningBrowser, answer: Answered) -> Any:
    doors = lab.server._doors
    assert doors is not None
    return doors.learner(page_of(browser, answer), cookies_of(browser))


def test_the_students_key_follows_from_the_secret_and_two_people_have_two(lab: Lab) -> None:
    keys = COURSE.keys
    one = keys.student("https://a.example", "1")
    assert re.fullmatch(r"[0-9a-f]{24}", one) and one == keys.student("https://a.example", "1")
    assert len({one, keys.student("https://a.example", "2"), keys.student("https://b.example", "1"),
                hmac.digest(b"a secret of a course, for tests alone", b"https://a.example\n1", "sha256").hex()[:24],
                sha256(b"1").hexdigest()[:24]}) == 5


def test_two_links_in_one_browser_keep_their_own_line_items(lab: Lab) -> None:
    browser, platform = lab.browser(), lab.platform
    one = platform.launch(browser, "kalman", resource_link={"id": "one"})
    two = platform.launch(browser, "kalman", resource_link={"id": "two"})
    assert launch_id(page_of(browser, one)) != launch_id(page_of(browser, two))
    assert _learner(lab, browser, one) is not None and _learner(lab, browser, two) is not None


def test_cookies_of_many_launches_do_not_pile_up(lab: Lab) -> None:
    browser = lab.browser()
    for k in range(MAX_LAUNCHES + 3):
        lab.platform.begin(browser)
        assert lab.platform.launch(browser, "kalman", resource_link={"id": str(k)}).status == 303
    assert sum("launch" in name for name in browser.cookies) == MAX_LAUNCHES
    assert sum("login" in name for name in browser.cookies) <= MAX_LOGINS
    assert len(browser.cookie_line) < 8000


def test_a_page_whose_launch_is_unknown_is_told_so(lab: Lab) -> None:
    with WireTab(lab.url, path="/?lti=0123456789abcdef", word=WORD) as tab:
        tab.until(lambda: phrases.LAUNCH_OVER("en") in tab.notes, "the sentence")
        assert lab.server.sessions


# --- hostile launches --------------------------------------------------------------------------------------------------
Forge = Callable[[LearningPlatform, dict[str, str]], str]


def _forged(**changes: Any) -> Forge:
    return lambda platform, asked: signed(platform.claims(asked, lesson="kalman", **changes))


def _with_public_key(platform: LearningPlatform, asked: dict[str, str]) -> str:
    """HS256 with the public key as the secret, for a verifier that lets the token choose."""
    public = key_pair("platform").public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
    return joined({"alg": "HS256", "kid": KID}, platform.claims(asked), lambda words: hmac.digest(public, words, "sha256"))


def _changed_after_signing(platform: LearningPlatform, asked: dict[str, str]) -> str:
    good, other = signed(platform.claims(asked)).split("."), signed(platform.claims(asked, user="somebody else")).split(".")
    return ".".join([good[0], other[1], good[2]])


HOSTILE: dict[str, tuple[Forge, str]] = {
    "wrong signature": (lambda p, a: signed(p.claims(a), "stranger"), "The signature of the launch is not the platform's."),
    "changed after signing": (_changed_after_signing, "The signature of the launch is not the platform's."),
    "unknown key": (lambda p, a: signed(p.claims(a), "stranger", "other"),
                    "The launch is signed by a key that the platform does not show."),
    "alg none": (lambda p, a: joined({"alg": "none", "kid": KID}, p.claims(a), lambda words: b""), "The launch must be signed with RS256."),
    "alg None": (lambda p, a: joined({"alg": "nOnE", "kid": KID}, p.claims(a), lambda words: b""), "The launch must be signed with RS256."),
    "HS256 with the public key": (_with_public_key, "The launch must be signed with RS256."),
    "no token": (lambda p, a: "a.b.c", "The launch holds no token that can be read."),
    "wrong audience": (_forged(aud="another-tool"), "The launch is meant for another tool."),
    "wrong party": (_forged(aud=[CLIENT, "another-tool"], azp="another-tool"), "The launch is meant for another tool."),
    "two audiences": (_forged(aud=[CLIENT, "another-tool"]), "The launch is meant for another tool."),
    "wrong issuer": (_forged(iss="https://evil.example"), "The launch comes from another platform than the login."),
    "expired": (_forged(iat=1_700_000_000, exp=1_700_000_300), "The launch has expired; open the lesson again in the learning platform."),
    "from the future": (_forged(iat=4_000_000_000, exp=4_000_000_300),
                        "The launch is dated in the future; the clocks of platform and lab differ."),
    "foreign nonce": (_forged(nonce="a-nonce-of-somebody-else"), "The launch does not answer the login of this browser."),
    "unknown deployment": (_forged(deployment_id="8"), "This lab does not know the platform's deployment."),
    "unknown kind": (_forged(message_type="LtiSubmissionReviewRequest"), "This lab does not know this kind of launch."),
    "unknown lesson": (lambda p, a: signed(p.claims(a, lesson="no-such-lesson")),
                       "This lab has no lesson of the name that the launch asks for."),
    "unknown scene": (lambda p, a: signed(p.claims(a, custom={"lesson": "kalman", "scene": "none"})),
                      "The lesson has no scene of the name that the launch asks for."),
    "return in the clear": (lambda p, a: signed(p.choice(a, deep_link_return_url="http://evil.example/")),
                            "The launch does not name its deep linking settings."),
    "return that ends the form": (lambda p, a: signed(p.choice(a, deep_link_return_url='https://a.example/"><script>')),
                                  "The launch does not name its deep linking settings."),
    "no links accepted": (lambda p, a: signed(p.choice(a, accept_types=["file"])), "The platform does not accept links to lessons here."),
} | {f"without {name}": (_forged(**{name: None}), "The launch lacks a claim that every launch has.")
     for name in ("iss", "aud", "exp", "iat", "nonce")} | {
    f"without {name}": (_forged(**{name: None}), f"The launch does not name its {said}.") for name, said in
    (("sub", "user"), ("version", "version 1.3.0"), ("deployment_id", "deployment"), ("resource_link", "resource link"),
     ("target_link_uri", "target"), ("roles", "roles"))}


def refused(lab: Lab, browser: LearningBrowser, answer: Answered, words: str) -> None:
    """One sentence, no way on, no cookie that lets anybody in, no session."""
    assert 400 <= answer.status < 500 and answer.text == f"{words}\n", answer
    assert answer.field("Location") == "" and answer.field("Content-Type").startswith("text/plain")
    assert not any("launch" in name or name == f"observer-lab-{urlsplit(lab.url).port}" for name in browser.cookies)
    assert browser.ask("/").status == 401


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_launch_is_refused_with_one_sentence_and_opens_nothing(lab: Lab, name: str) -> None:
    forge, words = HOSTILE[name]
    browser = lab.browser()
    asked = lab.platform.begin(browser)
    refused(lab, browser, browser.ask("/lti/launch", {"id_token": forge(lab.platform, asked), "state": asked["state"]}), words)


def test_a_launch_is_used_once(lab: Lab) -> None:
    browser, thief = lab.browser(), lab.browser()
    asked = lab.platform.begin(browser)
    form = {"id_token": signed(lab.platform.claims(asked)), "state": asked["state"]}
    thief.cookies = dict(browser.cookies)
    assert browser.ask("/lti/launch", form).status == 303
    refused(lab, thief, thief.ask("/lti/launch", form), "This launch was used before; open the lesson again in the learning platform.")


@pytest.mark.parametrize("state", ["its own", "made up", "changed"])
def test_a_launch_with_a_foreign_state_is_refused(lab: Lab, state: str) -> None:
    """An attacker's own launch, posted by another browser, would log that person in as the attacker."""
    attacker, victim = lab.browser(), lab.browser()
    asked, _ = lab.platform.begin(attacker), lab.platform.begin(victim)
    said = {"its own": asked["state"], "made up": "a" * 32, "changed": asked["state"][:-4] + "AAAA"}[state]
    if state == "changed":
        victim.cookies |= attacker.cookies
    answer = victim.ask("/lti/launch", {"id_token": signed(lab.platform.claims(asked)), "state": said})
    refused(lab, victim, answer, "This launch answers no login of this browser; allow cookies, or open the lesson in a window of its own.")


def test_a_cookie_that_was_made_up_is_no_login(lab: Lab) -> None:
    browser = lab.browser()
    asked = lab.platform.begin(browser)
    (name,) = [name for name in browser.cookies if "login" in name]
    browser.cookies[name] = browser.cookies[name][:-6] + "AAAAAA"
    answer = browser.ask("/lti/launch", {"id_token": signed(lab.platform.claims(asked)), "state": asked["state"]})
    refused(lab, browser, answer, "This launch answers no login of this browser; allow cookies, or open the lesson in a window of its own.")


@pytest.mark.parametrize(("changes", "words"), [
    ({"iss": "https://evil.example"}, "This lab does not know this platform."), ({"iss": ""}, "This lab does not know this platform."),
    ({"client_id": "another"}, "This lab does not know this platform."),
    ({"login_hint": ""}, "The login names no user: its login_hint is missing."),
])
def test_a_login_of_a_stranger_is_refused(lab: Lab, changes: dict[str, str], words: str) -> None:
    browser = lab.browser()
    said = {"iss": lab.platform.url, "login_hint": "1", "target_link_uri": lab.url, "client_id": CLIENT, **changes}
    refused(lab, browser, browser.ask(f"/lti/login?{urlencode(said)}"), words)
    refused(lab, browser, browser.ask("/lti/login", said), words)


@pytest.mark.parametrize(("form", "kind", "status"), [
    (b"id_token=" + b"x" * MAX_FORM_BYTES, "application/x-www-form-urlencoded", 413), (b"{}", "application/json", 415),
    (b"state=a&state=b", "application/x-www-form-urlencoded", 400), (b"&".join(b"f%d=1" % k for k in range(99)),
                                                                     "application/x-www-form-urlencoded", 400),
    (b"", "application/x-www-form-urlencoded", 400), (b"\xff\xfe=\x00", "application/x-www-form-urlencoded", 400),
    (b"error=login_required&state=a", "application/x-www-form-urlencoded", 403),
])
def test_a_form_that_is_too_large_or_none_is_refused(lab: Lab, form: bytes, kind: str, status: int) -> None:
    browser = lab.browser()
    answer = browser.ask("/lti/launch", form, kind)
    assert answer.status == status, answer
    refused(lab, browser, answer, answer.text.strip())
    assert answer.text.count("\n") == 1


def test_no_other_path_takes_a_form_and_the_gate_asks_for_the_host(lab: Lab) -> None:
    browser = lab.browser()
    assert [browser.ask(path, {"a": "b"}).status for path in ("/", "/health", "/lti", "/lti/launch/", "/lti/login2")] == [405] * 5
    place = urlsplit(lab.url)
    connection = http.client.HTTPConnection("127.0.0.1", place.port, timeout=20)
    connection.request("POST", "/lti/launch", b"a=b", {"Host": "evil.example", "Content-Type": "application/x-www-form-urlencoded"})
    assert connection.getresponse().status == 403


def test_a_flood_of_unknown_keys_does_not_flood_the_platform(lab: Lab) -> None:
    before = lab.platform.state.key_sets_given
    for _ in range(20):
        browser = lab.browser()
        asked = lab.platform.begin(browser)
        browser.ask("/lti/launch", {"id_token": signed(lab.platform.claims(asked), "stranger", "other"), "state": asked["state"]})
    assert lab.platform.state.key_sets_given - before <= 2
