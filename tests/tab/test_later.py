"""Under a moving knob what is looked at is shown first; the rest follows, unless the hand goes on, and a rest that fails undoes it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from fakes import UNDRAWABLE, FakeView, Tab, toy, toy_compute, toy_figures

from observer_lab.course.figures.records import Figure
from observer_lab.course.lazy import FigureSet, LazyMap, LazyValue, tab_figures
from observer_lab.course.lesson import Design, Lesson, Outcome
from observer_lab.session.commands.commands import PlaceOpened, SetKnobs, Undo
from observer_lab.text import same


@dataclass
class Diary:
    """Which leaves have been made, of which gain; and edits that come while a picture is being shown."""

    made: list[tuple[str, float]] = field(default_factory=list)
    waiting: list[SetKnobs] = field(default_factory=list)


def paged(diary: Diary) -> Lesson:
    """The toy with tabs "near" and "far" and a figure that nobody follows; a gain of UNDRAWABLE fails in the far one alone."""
    def compute(design: Design) -> Outcome:
        whole = toy_compute(design)
        return replace(whole, metrics=LazyMap(lambda: diary.made.append(("numbers", design["gain"])) or {"gain": design["gain"]}),
                       words=LazyValue(lambda: same("late")))

    def figures(outcome: Outcome) -> FigureSet:
        def made(name: str) -> tuple[Figure, ...]:
            diary.made.append((name, outcome.design["gain"]))
            shown = outcome if name == "far" else replace(outcome, design=outcome.design.with_values(gain=0.0))
            return (replace(toy_figures(shown)[0], id=name, tab=same("near" if name == "slow" else name)),)
        return FigureSet(tab_figures(same("near"), lambda: made("near")), tab_figures(same("near"), lambda: made("slow"), "late"),
                     tab_figures(same("far"), lambda: made("far")))
    return toy(compute=compute, figures=figures)


def opened(diary: Diary) -> Tab:
    tab = Tab({"toy": paged(diary)})
    shows = tab.view.show

    def show(picture) -> None:
        shows(picture)
        len(picture.seen)  # as a screen does
        if diary.waiting:
            tab.session.post(diary.waiting.pop())
    tab.view.show = show
    diary.made.clear()
    return tab


def seen(view: FakeView) -> list[tuple[float, list[str]]]:
    """The gain and the figures of every picture that was shown."""
    return [(picture.design["gain"], [figure.id for figure in picture.seen]) for picture in view.of("show")]


def test_the_open_tab_is_shown_before_the_rest_is_computed() -> None:
    diary = Diary()
    tab = opened(diary)
    tab.set(gain=2.0)
    assert seen(tab.view) == [(2.0, ["near"]), (2.0, ["near", "slow", "far"])] and not tab.view.of("show")[0].whole
    assert diary.made == [("near", 2.0), ("slow", 2.0), ("far", 2.0), ("numbers", 2.0)] and tab.picture.outcome.live == same("late")
    tab.do(PlaceOpened(1, None))
    tab.view.clear()
    tab.set(gain=3.0)
    assert seen(tab.view)[0] == (3.0, ["far"])


def test_a_hand_that_goes_on_spares_the_rest_of_what_is_over() -> None:
    diary = Diary(waiting=[SetKnobs({"gain": 4.0}), SetKnobs({"gain": 3.0})])
    tab = opened(diary)
    for _ in range(3):
        tab.session.step(0.0) if diary.made else tab.set(gain=2.0)
    assert [name for name, gain in diary.made if gain < 4.0] == ["near", "near"]
    assert seen(tab.view) == [(2.0, ["near"]), (3.0, ["near"]), (4.0, ["near"]), (4.0, ["near", "slow", "far"])]
    tab.do(Undo())
    assert tab["gain"] == 1.0 and tab.picture.whole


def test_a_rest_that_fails_goes_back_to_the_last_whole_picture() -> None:
    diary = Diary(waiting=[SetKnobs({"gain": UNDRAWABLE})])
    tab = opened(diary)
    tab.set(gain=2.0)
    tab.session.step(0.0)
    assert tab["gain"] == 1.0 and tab.shown.whole and tab.view.scolded()
    tab.set(gain=5.0)
    tab.do(Undo())
    assert tab["gain"] == 1.0
