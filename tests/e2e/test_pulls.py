"""The plant itself is pulled with the mouse, a finger and keys; the page's address says so, and letting go ends the force."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from geometry import on_screen
from playwright.sync_api import Browser
from sampling import some
from tab import Tab, eventually

from observer_lab.course.lesson import Lesson
from observer_lab.lessons import LESSONS
from observer_lab.plants.grip import Grip
from observer_lab.session.state.token import read_token

PLANTS = ("separation", "error-dynamics", "saturation", "arm", "hidden-modes")  # deck, block, pole and cart, arm, two masses
WAY = 50.0  # px that a hand goes
HAND = "() => observerLabSlide.held === null && [...document.querySelectorAll('input[data-springs]')].every(each => each.value === '0')"


def first_grip(lesson: Lesson) -> Grip:
    """The first place at which the plant of a lesson can be pulled."""
    stage = lesson.compute(lesson.start()).stage
    assert stage is not None
    return stage.held[0][0]


def open_for_a_hand(tab: Tab, id: str) -> Grip:
    """A lesson after its prediction."""
    lesson = LESSONS[id]
    tab.choose_lesson(lesson.words["en"].title, lesson.words["en"].question)
    if tab.page.locator(".ol-veil").count():
        tab.predict("skip")
    tab.answered(rests=True)
    return first_grip(lesson)


def record(tab: Tab, grip: Grip) -> tuple[tuple[float, float], ...]:
    """What the page's own address says of the hand."""
    return read_token(tab.page.evaluate("location.hash"), LESSONS).design[grip.knob]


def was_let_go(forces: tuple[tuple[float, float], ...]) -> bool:
    """Whether a record has a pull that is over."""
    return any(force for _, force in forces) and forces[-1][1] == 0.0


def pulls(tab: Tab, grip: Grip, hand: Callable[[float, float], None], what: str) -> None:
    """Take the plant where it is now and pull. It moves meanwhile, and a hand may miss it: then it tries again."""
    def tried() -> tuple[tuple[float, float], ...]:
        hand(*on_screen(tab, f"/plant/{grip.parts[0]}"))
        tab.answered(rests=True)
        return record(tab, grip)
    eventually(tried, was_let_go, what)


def test_mouse_and_keys_pull_five_plants(new_tab: Callable[..., Tab]) -> None:
    tab = new_tab(1280, 760)
    for id in some("mouse and keys pull", PLANTS, 3):
        grip = open_for_a_hand(tab, id)

        def hand(x: float, y: float, grip: Grip = grip) -> None:
            mouse = tab.page.mouse
            mouse.move(x, y)
            tab.answered()
            mouse.down()
            for k in range(1, 4):
                mouse.move(x + grip.along[0] * WAY * k / 3, y - grip.along[2] * WAY * k / 3)
                tab.answered()
            mouse.up()
        pulls(tab, grip, hand, f"the mouse pulls in {id}")
        tab.key("z")
        eventually(lambda grip=grip: record(tab, grip), lambda forces: not forces, f"one undo takes the pull in {id} back")
        slider = tab.page.locator("input[data-springs]").first
        assert slider.evaluate("each => each.labels[0].textContent").startswith(("force of a hand", "torque of a hand"))
        slider.focus()
        for _ in range(3):
            tab.page.keyboard.down("ArrowRight")
            tab.answered()
        tab.page.keyboard.up("ArrowRight")
        tab.answered(rests=True)
        eventually(lambda grip=grip: record(tab, grip), was_let_go, f"the arrow keys pull in {id}")
        eventually(lambda: tab.page.evaluate(HAND), bool, "the slider springs back")


@pytest.mark.parametrize("ids", [PLANTS[:3], PLANTS[3:]], ids=["three", "two"])
def test_a_finger_pulls_five_plants(browser: Browser, server: str, ids: tuple[str, ...]) -> None:
    context = browser.new_context(viewport={"width": 900, "height": 844}, reduced_motion="reduce", has_touch=True)
    tab = Tab(context.new_page(), server, drawn=False)
    touch = context.new_cdp_session(tab.page)
    for id in ids:
        grip = open_for_a_hand(tab, id)

        def hand(x: float, y: float, grip: Grip = grip) -> None:
            touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
            for k in range(1, 6):
                at = {"x": x + grip.along[0] * WAY * k / 5, "y": y - grip.along[2] * WAY * k / 5}
                touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [at]})
                tab.sent()
            touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        pulls(tab, grip, hand, f"a finger pulls in {id}")
    context.close()
    assert not tab.complaints
