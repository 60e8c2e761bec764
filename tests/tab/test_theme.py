"""The window of a browser: its size counts in large print alone, the dark follows its owner until a button is pressed."""

from __future__ import annotations

import math

from fakes import FakeView, Tab, toy
from test_reload import Again

from observer_lab.session.commands.commands import MemoryRecalled, ToggleLecture, ToggleTheme, WindowChanged
from observer_lab.session.session import Session
from observer_lab.session.state.view import USUAL


def test_the_page_follows_the_browser_into_the_dark_until_a_button_is_pressed() -> None:
    tab = Tab()
    tab.do(WindowChanged(1366.0, 768.0, 1.0))
    assert tab.picture.state.is_dark and len(tab.view.of("build")) == 1
    tab.do(ToggleTheme())
    assert not tab.picture.state.is_dark
    tab.do(WindowChanged(1366.0, 768.0, 1.0))
    assert not tab.picture.state.is_dark and len(tab.view.of("build")) == 2


def test_a_page_that_tells_of_its_window_before_it_is_laid_out_is_laid_out_for_it_once() -> None:
    for told, window, dark in (((768, 1024, True), (768.0, 1024.0), True), ((1e9, -3, False), (20_000.0, 200.0), False),
                               (("wide", 5, 0), USUAL, False), ((math.nan, 700, True), USUAL, False), (({}, [], None), USUAL, False)):
        view = FakeView(answers=False)
        session = Session({"toy": toy()}, view, "toy")
        session.post(MemoryRecalled(None, window=told))
        session._begin()
        built = view.of("build")
        assert len(built) == 1 and built[0].state.window == window and built[0].state.is_dark == dark
        if window != USUAL:
            session.post(WindowChanged(*window, float(dark)))
            session.step()
            assert len(view.of("build")) == 1


def test_a_window_that_changes_is_laid_out_anew_in_large_print_alone() -> None:
    tab = Tab()
    tab.do(WindowChanged(1920.0, 1080.0, 0.0))
    assert not tab.view.of("build") and tab.picture.state.window == (1920.0, 1080.0), "the run's panel follows"
    tab.do(ToggleLecture())
    tab.do(WindowChanged(1920.0, 1079.0, 0.0))
    assert len(tab.view.of("build")) == 1
    tab.do(WindowChanged(3840.0, 2160.0, 0.0))
    assert len(tab.view.of("build")) == 2 and tab.picture.state.window == (3840.0, 2160.0)


def test_nonsense_about_a_window_changes_nothing() -> None:
    tab = Tab()
    before = tab.session.picture
    for across, up in ((math.nan, 768.0), ("wide", 768.0), (None, None)):
        tab.do(WindowChanged(across, up, 0.0))
    assert tab.picture.state.window == before.state.window and len(tab.view.scolded()) == 3  # type: ignore[union-attr]
    tab.do(WindowChanged(-5.0, 1e12, 0.0))
    tab.do(ToggleLecture())
    assert all(100.0 < side < 1e5 for side in tab.picture.state.window)


def test_a_window_that_tells_its_size_is_no_work_that_a_reload_could_lose() -> None:
    tab = Again({"first": toy("first")}, None)
    tab.do(WindowChanged(1920.0, 1080.0, 0.0))
    assert not tab.session._show.touched
