"""A class in three browsers: votes of all kinds, a copy of one's own, a restart; then a run for each follower, a hand-in, a grade."""

from __future__ import annotations

import csv
import json
import re
import socket
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from redis_server import RedisServer
from tab import Tab

from observer_lab.classroom.kept_room import open_room
from observer_lab.classroom.room_store import RoomStore
from observer_lab.cli import main
from observer_lab.cli.courses import course_in
from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases

PATIENCE = 180_000  # ms: a busy machine is slow
ARTEFACTS = Path(__file__).parents[2] / "artefacts"
PREDICT, DRAG = (next(k for k, scene in enumerate(LESSONS["separation"].path) if scene.id == name) for name in ("predict", "drag"))
COURSE = """
course = "course-of-a-class"
secret = "a secret of a course, for tests alone"
points = 5

[[lessons]]
lesson = "kalman"
exams = ["sheet"]
"""
expect.set_options(timeout=PATIENCE)
Serve = Callable[..., AbstractContextManager[str]]


@pytest.fixture
def opened(still_page: Callable[..., Page]) -> Callable[..., Page]:
    """Opens an address; a narrow page is touched."""
    def make(address: str, size: tuple[int, int] = (1366, 768)) -> Page:
        page = still_page(*size, has_touch=size[0] < 500)
        page.set_default_timeout(PATIENCE)
        page.goto(address)
        page.wait_for_selector(".ol-scene")
        return page
    return make


def kept_pictures(kind: str, **pages: Page) -> None:
    """For people to look at."""
    ARTEFACTS.mkdir(exist_ok=True)
    for name, page in pages.items():
        page.evaluate("() => { window.observerLabDraws = true; window.__viserMutable.requestRender(); }")
        page.screenshot(path=ARTEFACTS / f"room-{kind}{name}.png", timeout=PATIENCE)
        page.evaluate("() => { window.observerLabDraws = false; }")


def others_vote(folder: Path, answers: Sequence[complex]) -> None:
    """More of the class, as another worker writes their votes down."""
    store = RoomStore(folder)
    assert all(store.cast([(store.votes()[-1].number, f"other{k:05d}", answer) for k, answer in enumerate(answers)]))
    store.close()


class OwnCopy(Tab):
    """A page that is open already, in the lab."""

    def open(self) -> None:
        self.page.wait_for_selector(".ol-question")


def shows(page: Page, scene: str) -> None:
    expect(page.locator(f".ol-card[data-scene={scene}]")).to_be_visible()


def vote(page: Page, option: int, letter: str) -> None:
    page.locator(".ol-option").nth(option).click()
    expect(page.get_by_text(f"Your answer {letter} is counted.").last).to_be_visible()


def open_a_typed_vote(presenter: Page, question: str) -> None:
    presenter.get_by_text("Ask the class a question of your own").click()
    presenter.locator(".ol-ask textarea").fill(question)
    presenter.locator(".ol-ask").get_by_role("button", name="Open the vote").click()


def test_a_class_votes_places_poles_tries_for_itself_comes_back_and_survives_a_restart(opened: Callable[..., Page],
                                                                                      serve: Serve, tmp_path: Path) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    options = ("--view", "guide", "--lesson", "separation", "--room", "--data-dir", str(tmp_path), "--exact-port")
    with serve(port, *options) as address:
        secret = RoomStore(tmp_path).secret
        laptop = opened(address)
        expect(laptop.get_by_text("The lecture has not begun yet.")).to_be_visible()
        presenter, phone = opened(f"{address}/?present={secret}"), opened(address, (390, 844))
        assert secret not in presenter.url, "the word leaves the address bar"
        for page in (presenter, laptop, phone):
            shows(page, LESSONS["separation"].path[0].id)
        presenter.get_by_text("The audience's link and its code").click()
        expect(presenter.locator(".ol-code")).to_be_visible()
        expect(presenter.get_by_text(f"{address}/", exact=True)).to_be_visible()
        presenter.get_by_text("The audience's link and its code").click()
        phone.get_by_role("button", name="Slower, please").click()
        expect(presenter.locator(".ol-slower")).to_contain_text("slower, please: 1")
        vote_on_the_scene_twice(presenter, laptop, phone, tmp_path)
        laptop.get_by_role("link", name="Try it myself").click()
        back = laptop.get_by_role("link", name="Back to the lecture")
        expect(back).to_be_visible()
        shows(laptop, "predict")
        laptop.locator(".ol-dot").nth(PREDICT + 1).click()
        shows(laptop, "why")
        shows(presenter, "predict")
        back.click()
        shows(laptop, "predict")
    with serve(port, *options):
        for page in (laptop, phone, presenter):
            expect(page.locator(".ol-lost")).to_be_hidden()
            expect(page.locator(".ol-cover")).to_be_hidden()
            shows(page, "predict")
        presenter.get_by_role("button", name="Close the vote").click()
        presenter.get_by_role("button", name="Reveal the answer").click()
        expect(laptop.locator(".ol-poll")).to_have_count(2)
        see_both_votes_in_the_hall(presenter)
        open_a_typed_vote(presenter, "How many poles has the loop?")
        phone.get_by_role("spinbutton", name="your number").fill("12")
        phone.get_by_role("button", name="Send").click()
        expect(phone.get_by_text("Your answer 12 is counted.")).to_be_visible()
        kept_pictures("typed-", presenter=presenter, phone=phone)
        place_poles_in_guide_and_lab(presenter, laptop, phone, tmp_path)
        assert [each.total for each in RoomStore(tmp_path).votes()] == [6, 6, 1, 6, 1]


def vote_on_the_scene_twice(presenter: Page, laptop: Page, phone: Page, folder: Path) -> None:
    """The question of the scene before and after its explanation: counts that are hidden, then two histograms side by side."""
    presenter.locator(".ol-dot").nth(PREDICT).click()
    for page in (laptop, phone):
        shows(page, "predict")
        expect(page.locator(".ol-option:enabled")).to_have_count(0)
    presenter.get_by_role("button", name="Open the vote").first.click()
    vote(laptop, 0, "A")
    vote(phone, 1, "B")
    vote(laptop, 1, "B")
    expect(presenter.locator(".ol-poll")).to_contain_text("2 votes")
    expect(presenter.locator(".ol-here")).to_contain_text("2 here")
    assert presenter.locator(".ol-bar").count() == 0 and RoomStore(folder).votes()[-1].counts == (0, 2, 0)
    others_vote(folder, [0, 0, 2, 2])
    expect(presenter.locator(".ol-poll")).to_contain_text("6 votes")
    presenter.get_by_role("button", name="Close the vote").click()
    presenter.get_by_role("button", name="Show the counts").click()
    for page in (presenter, laptop, phone):
        expect(page.locator(".ol-bar")).to_have_count(3)
        tree = page.locator(".ol-card").aria_snapshot()
        assert "heading" in tree and page.locator(".ol-option.ol-right").count() == 0, tree
    presenter.get_by_role("button", name="Discuss").click()
    for page in (presenter, laptop, phone):
        expect(page.locator(".ol-countdown")).to_have_text(re.compile("[12]:[0-5][0-9]"))
    presenter.get_by_role("button", name="Ask again").first.click()
    vote(phone, 1, "B")
    for page in (presenter, laptop, phone):
        expect(page.locator(".ol-right, .ol-say")).to_have_count(0)
    others_vote(folder, [1, 1, 1, 1, 0])
    expect(presenter.locator(".ol-poll").nth(1)).to_contain_text("6 votes")
    kept_pictures("", presenter=presenter, laptop=laptop, phone=phone)


def see_both_votes_in_the_hall(presenter: Page) -> None:
    """In large print both histograms stand side by side over the stage, and bars and letters are large."""
    presenter.get_by_role("button", name="Present", exact=True).click()
    polls = presenter.locator(".ol-hall .ol-poll")
    expect(polls).to_have_count(2)
    one, other = (polls.nth(k).bounding_box() for k in range(2))
    assert one is not None and other is not None and one["y"] == other["y"] and other["x"] >= one["x"] + one["width"] >= one["x"] + 300
    sizes = presenter.locator(".ol-hall .ol-bar b").evaluate_all("all => all.map(each => parseFloat(getComputedStyle(each).fontSize))")
    assert len(sizes) == 6 and min(sizes) >= 24
    kept_pictures("hall-", presenter=presenter)
    presenter.get_by_role("button", name="Guide", exact=True).click()
    expect(presenter.locator(".ol-hall")).to_be_hidden()


def place_poles_in_guide_and_lab(presenter: Page, laptop: Page, phone: Page, folder: Path) -> None:
    """A finger on the phone, arrow keys on the laptop, the cloud on the card; then a number in the lab."""
    presenter.get_by_role("button", name="Close the vote").first.click()
    presenter.locator(".ol-dot").nth(DRAG).click()
    shows(phone, "drag")
    presenter.locator(".ol-room").get_by_role("button", name="Ask for a pole").click()
    plane = phone.locator(".ol-place svg")
    expect(plane).to_be_visible()
    expect(phone.get_by_role("button", name="Send")).to_be_disabled()
    box = plane.bounding_box()
    assert box is not None and box["width"] <= 390
    plane.tap(position={"x": 0.4 * box["width"], "y": 0.3 * box["height"]})
    said = phone.locator(".ol-place output").inner_text()
    assert re.fullmatch(r"−[\d.]+ ± [\d.]+j", said), said
    tree = phone.locator(".ol-typed").aria_snapshot()
    assert 'application "complex plane' in tree and said in tree and 'button "Send"' in tree, tree
    phone.get_by_role("button", name="Send").click()
    expect(phone.get_by_text(f"Your answer {said} is counted.")).to_be_visible()
    laptop.locator(".ol-place svg").focus()
    for key in ("ArrowLeft", "ArrowUp", "Shift+ArrowUp"):
        laptop.keyboard.press(key)
    placed = laptop.locator(".ol-place output").inner_text()
    laptop.keyboard.press("Enter")
    expect(laptop.get_by_text(f"Your answer {placed} is counted.")).to_be_visible()
    expect(presenter.locator(".ol-poll")).to_contain_text("2 votes")
    others_vote(folder, [-4 + 2j, -4 + 2j, -2 + 0j, -6 + 0j])
    expect(presenter.locator(".ol-poll")).to_contain_text("6 votes")
    presenter.get_by_role("button", name="Close the vote").click()
    expect(presenter.get_by_role("button", name="Show the counts")).to_be_visible()
    assert presenter.locator(".ol-placed").count() == phone.locator(".ol-placed").count() == 0, "no pole before it is shown"
    presenter.get_by_role("button", name="Show the counts").click()
    expect(presenter.locator(".ol-placed")).to_have_count(8)
    expect(phone.locator(".ol-placed")).to_have_count(8)
    kept_pictures("poles-", presenter=presenter, phone=phone)
    presenter.get_by_role("button", name="Lab", exact=True).click()
    presenter.wait_for_selector(".ol-question")
    open_a_typed_vote(presenter, "How many states?")
    phone.get_by_role("spinbutton", name="your number").fill("6")
    phone.get_by_role("button", name="Send").click()
    expect(phone.get_by_text("Your answer 6 is counted.")).to_be_visible()
    expect(presenter.locator(".ol-poll")).to_contain_text("1 vote")
    kept_pictures("lab-", presenter=presenter)
    presenter.get_by_role("button", name="Close the vote").click()
    presenter.get_by_role("button", name="Show the counts").click()
    expect(phone.locator(".ol-poll")).to_contain_text("1 vote. Below 5 no counts are shown")


def test_a_class_on_redis_runs_one_seed_each_and_an_answer_is_handed_in_and_graded(
        opened: Callable[..., Page], serve: Serve, tmp_path: Path, redis_server: RedisServer, capsys: pytest.CaptureFixture[str]) -> None:
    redis_server.empty()
    file = tmp_path / "course.toml"
    file.write_text(COURSE, encoding="utf-8")
    with serve(0, "--view", "guide", "--lesson", "kalman", "--room", "--room-store", redis_server.address,
               "--course", str(file)) as address:
        presenter = opened(f"{address}/?present={open_room(redis_server.address).secret}")
        laptop, phone = opened(address), opened(address, (390, 844))
        expect(presenter.locator(".ol-here")).to_contain_text("2 here · following: 2")
        presenter.get_by_role("button", name="Run one seed for each follower").click()
        expect(presenter.locator(".ol-seeds")).to_contain_text("average NEES")
        expect(presenter.locator(".ol-seeds circle")).to_have_count(2)
        for page in (laptop, phone):
            expect(page.locator(".ol-own-run")).to_contain_text("Your run")
        assert laptop.locator(".ol-own-run svg").inner_html() != phone.locator(".ol-own-run svg").inner_html()
        kept_pictures("cloud-", presenter=presenter, phone=phone)
        laptop.get_by_role("link", name="Try it myself").click()
        expect(laptop.get_by_role("link", name="Back to the lecture")).to_be_visible()
        laptop.get_by_role("button", name="Lab", exact=True).click()
        token = handed_in(OwnCopy(laptop, address), str(file), capsys)
        expect(presenter.locator(".ol-here")).to_contain_text("2 here · following: 1")
    assert main(["grade", token, "--course", str(file), "-o", str(tmp_path / "grades.csv")]) == 0
    assert "hand-ins: 1, counted: 1, students: 1" in capsys.readouterr().out
    with (tmp_path / "grades.csv").open(encoding="utf-8", newline="") as table:
        assert list(csv.DictReader(table)) == [{"ID number": "s1", "kalman exam sheet": "5"}]


def handed_in(copy: Tab, course: str, capsys: pytest.CaptureFixture[str]) -> str:
    """The signed right answer of a student, as the page shows it."""
    assert main(["variant", "s1", "--course", course, "--json"]) == 0
    (item,) = json.loads(capsys.readouterr().out)["items"]
    copy.unfold(phrases.EXAM("en"))
    copy.row("your key").locator("input").fill("s1")
    copy.row("your word").locator("input").fill(course_in(course).keys.word("s1"))
    copy.answered()
    copy.unfold(f"1 {LESSONS['kalman'].words['en'].exams['sheet'].title}")
    copy.row("answer").locator("input").fill(str(item["answer"]))
    copy.answered()
    copy.press("hand in")
    field = copy.page.locator(".ol-link")
    expect(field).not_to_have_value("")
    return field.input_value()
