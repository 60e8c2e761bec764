"""The window of a browser: its size counts in large print alone, the dark follows its owner until a button is pressed."""

from __future__ import annotations

import math

from fakes import FakeView, Tab, toy
from test_reload import Again

from app.tab.commands import Recalled, SeeWindow, ToggleLecture, ToggleTheme
from app.tab.picture import USUAL
from app.tab.session import Session


def test_the_page_follows_the_browser_into_the_dark_until_a_button_is_pressed() -> None:
    tab = Tab()
    tab.do(SeeWindow(1366.0, 768.0, 1.0))
    assert tab.picture.state.darkness and len(tab.view.of("build")) == 1
    tab.do(ToggleTheme())
    assert not tab.picture.state.darkness
    tab.do(SeeWindow(1366.0, 768.0, 1.0))
    assert not tab.picture.state.darkness and len(tab.view.of("build")) == 2


def test_a_page_that_tells_of_its_window_before_it_is_laid_out_is_laid_out_for_it_once() -> None:
    for told, window, dark in (((768, 1024, True), (768.0, 1024.0), True), ((1e9, -3, False), (20_000.0, 200.0), False),
                               (("wide", 5, 0), USUAL, False), ((math.nan, 700, True), USUAL, False), (({}, [], None), USUAL, False)):
        view = FakeView(answers=False)
        session = Session({"toy": toy()}, view, "toy")
        session.post(Recalled(None, window=told))
        session._begin()
        built = view.of("build")
        assert len(built) == 1 and built[0].state.window == window and built[0].state.darkness == dark
        if window != USUAL:
            session.post(SeeWindow(*window, float(dark)))
            session.step()
            assert len(view.of("build")) == 1


def test_a_window_that_changes_is_laid_out_anew_in_large_print_alone() -> None:
    tab = Tab()
    tab.do(SeeWindow(1920.0, 1080.0, 0.0))
    assert not tab.view.of("build") and tab.picture.state.window == (1920.0, 1080.0), "the run's panel follows"
    tab.do(ToggleLecture())
    tab.do(SeeWindow(1920.0, 1079.0, 0.0))
    assert len(tab.view.of("build")) == 1
    tab.do(SeeWindow(3840.0, 2160.0, 0.0))
    assert len(tab.view.of("build")) == 2 and tab.picture.state.window == (3840.0, 2160.0)


def test_nonsense_about_a_window_changes_nothing() -> None:
    tab = Tab()
    before = tab.session.picture
    for across, up in ((math.nan, 768.0), ("wide", 768.0), (None, None)):
        tab.do(SeeWindow(across, up, 0.0))
    assert tab.picture.state.window == before.state.window and len(tab.view.scolded()) == 3  # type: ignore[union-attr]
    tab.do(SeeWindow(-5.0, 1e12, 0.0))
    tab.do(ToggleLecture())
    assert all(100.0 < side < 1e5 for side in tab.picture.state.window)


def test_a_window_that_tells_its_size_is_no_work_that_a_reload_could_lose() -> None:
    tab = Again({"first": toy("first")}, None)
    tab.do(SeeWindow(1920.0, 1080.0, 0.0))
    assert not tab.session._show.touched
