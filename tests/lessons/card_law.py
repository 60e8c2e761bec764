"""Law A: in every scene, whatever a hand does there, the card is true of the state that it shows.

`python tests/lessons/card_law.py [LESSON …]` enters each scene of each path and does nothing, each option, the action right, the wrong
way, too far and hardly, another button, and a task's knobs half-way; then it leaves and comes back by Next and Back, reload, language,
view, link, undo. It prints how many states were tried and which cards were false. A witness computes a verdict's numbers anew from the
design that was done.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from html import unescape
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    tests = Path(__file__).resolve().parents[1]
    sys.path[:0] = [str(tests.parent), str(tests), str(tests / "tab")]

from fakes import FakeView
from test_paths import Walker
from verdict_law import Said, witnesses
from verdict_words import words_in

from observer_lab.course.guiding.predictions import prediction_of
from observer_lab.course.knobs import Choice, Knob, KnobError, Poles, Switch
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose, Goal, Move, Press, Read, Solve, places_of
from observer_lab.engine import EngineError
from observer_lab.lessons import LESSONS
from observer_lab.page.guide.scene_card import card_html, verdict_html
from observer_lab.page.words import phrases
from observer_lab.session.commands.commands import Kick, OpenState, Play, SetKnobs, SetLanguage, Undo
from observer_lab.session.commands.guide import ChooseOption, GoToScene, RestartScene, SetMode, ShowKeptRun, TurnScene
from observer_lab.session.session import Session
from observer_lab.session.state.token import write_token

PRAISE = re.compile(r"\b(solved|right|correct)\b", re.I)
SHARES = {"wrong way": -0.4, "hardly": 0.004, "too far": 1.0}


@dataclass
class Cards:
    """What was tried: states by what was done in them, and the cards that were false."""

    tried: Counter[str] = field(default_factory=Counter)
    words: Counter[str] = field(default_factory=Counter)
    false: list[str] = field(default_factory=list)

    def hold(self, what: str, holds: bool, why: str) -> None:
        """One state that was tried, and whether its card is true."""
        self.tried[what] += 1
        if not holds:
            self.false.append(f"{what}: {why}")


def plain(html: str) -> str:
    """The words of a piece of page."""
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", " ", html))).strip()


def verdict(walker: Walker) -> str:
    """What the card says of what was done, without its buttons and without what has changed since."""
    picture = walker.session.picture
    assert picture is not None
    told = verdict_html(picture, "hand")
    told = told[:told.index('<div class="ol-way">')]
    return plain(re.sub(r'<p class="ol-note">[^<]*<button.*?</p>', "", told))


def question(walker: Walker) -> str:
    """What the card asks, with its numbers."""
    picture = walker.session.picture
    assert picture is not None
    return plain(re.findall(r'<div class="ol-text">(.*?)</div>', card_html(picture, "hand"), re.S)[0])


def opened(lesson: Lesson, index: int) -> Walker:
    """A tab at a scene, come to by its dot."""
    walker = Walker(lesson.id)
    walker.session.restore(None)
    walker.send(GoToScene(index), 0.3)
    return walker


def wrong_values(knob: Knob, value: Any, goal: Goal) -> Iterator[tuple[str, Any]]:
    """Values that do not reach a goal: the wrong way, too far, hardly moved, another setting."""
    if isinstance(knob, Switch):
        return
    if isinstance(knob, Choice):
        yield from (("another", key) for key, _ in knob.options if key not in (goal.value, value))
        return
    sign = -1.0 if goal.way == "left" else 1.0
    if isinstance(knob, Poles):
        away = {"wrong way": 1.3 if sign > 0 else 0.7, "hardly": 1.0 - 0.004 * sign}
        yield from ((what, tuple(complex(p.real * share, p.imag) for p in value)) for what, share in away.items())
        yield "too far", tuple(complex(0.3, p.imag) for p in value)
        return
    low, high = knob.low, knob.high  # type: ignore[attr-defined]
    if goal.way:
        edge = low if sign > 0 else high
        yield "wrong way", value + 0.5 * (edge - value)
        if getattr(knob, "scale", "linear") != "log":
            yield "hardly", value + 0.004 * sign * (high - low)
    if goal.least is not None and goal.least > low:
        yield "too little", low + 0.9 * (goal.least - low) if value > goal.least or value == low else value + 0.5 * (goal.least - value)
    if goal.most is not None and goal.most < high:
        yield "too far", goal.most + 0.5 * (high - goal.most)


def wrong_actions(lesson: Lesson, walker: Walker) -> Iterator[tuple[str, object]]:
    """Edits that are not what the open scene asks for."""
    picture = walker.session.picture
    assert picture is not None
    match walker.scene.do:
        case Move(knobs, goal) if goal is not None:
            knob = lesson.knob(knobs[0])
            for what, value in wrong_values(knob, picture.design[knob.name], goal):
                try:
                    kept = knob.check(value)
                except (KnobError, EngineError):
                    continue
                if kept != picture.design[knob.name]:
                    yield what, SetKnobs({knob.name: kept})
            for other in walker.scene.knobs:
                if other not in knobs and isinstance(lesson.knob(other), Switch):
                    yield "another knob", SetKnobs({other: not picture.design[other]})
        case Press(button):
            yield "another button", Play() if button != "play" else Kick()
        case Solve(task):
            asked = next(each for each in lesson.tasks if each.id == task)
            for name, value in asked.solution.items():
                before = picture.design[name]
                if isinstance(value, (int, float)) and not isinstance(value, bool) and isinstance(before, (int, float)):
                    yield "half-way", SetKnobs({name: lesson.knob(name).check(before - 0.5 * (value - before)
                                                if lesson.knob(name).low <= before - 0.5 * (value - before) <= lesson.knob(name).high  # type: ignore[attr-defined]
                                                else before)})
        case _:
            return


def reaches(lesson: Lesson, walker: Walker) -> bool:
    """Whether the scene's request is met by the design that is shown, judged here by its data alone."""
    picture = walker.session.picture
    assert picture is not None
    match walker.scene.do:
        case Move(knobs, goal) if goal is not None:
            knob, began = lesson.knob(knobs[0]), picture.began
            assert began is not None
            now, before = picture.design[knob.name], began[knob.name]
            if goal.value is not None:
                return bool(now == goal.value)
            if isinstance(knob, Poles):
                now, before = max(p.real for p in now), max(p.real for p in before)
                if now >= 0:
                    return False
            return bool((goal.way != "right" or now > before) and (goal.way != "left" or now < before)
                        and (goal.least is None or now >= goal.least) and (goal.most is None or now <= goal.most))
        case Solve(task):
            asked = next(each for each in lesson.tasks if each.id == task)
            return asked.check(lesson.compute(picture.design)).solved
        case _:
            return False


def entered(lesson: Lesson, index: int, found: Cards) -> None:
    """Nothing is done: the card asks and says no verdict."""
    walker, scene = opened(lesson, index), lesson.path[index]
    picture, here = walker.session.picture, f"{lesson.id} {scene.id}"
    assert picture is not None
    card, said = plain(card_html(picture, "hand")), verdict(walker)
    asks = lesson.words["en"].scenes[scene.id].do
    if isinstance(scene.do, Read):
        return
    found.hold("nothing", scene.id not in walker.done and not said, f"{here}: says “{said}”")
    found.hold("asked", not asks or "ol-todo" in card_html(picture, "hand"), f"{here}: no request in “{card}”")


def wronged(lesson: Lesson, index: int, found: Cards) -> None:
    """Something else is done: it is not praised, what happened is said, the request stays."""
    scene = lesson.path[index]
    for what, edit in wrong_actions(lesson, opened(lesson, index)):
        walker, linked = opened(lesson, index), Walker(lesson.id)
        linked.session.restore(None)
        linked.send(OpenState(write_token(lesson, walker.session._show.saved())), 0.3)
        for each in (walker, linked):
            each.send(edit, 1.0)
        here, said = f"{lesson.id} {scene.id} {edit}", verdict(walker)
        found.hold(f"{what}, by a link", verdict(linked) == said, f"{here}: “{verdict(linked)}” for “{said}”")
        done, should = scene.id in walker.done, what != "hardly" and reaches(lesson, walker)
        picture = walker.session.picture
        assert picture is not None
        found.hold(what, done == should, f"{here}: {'praised' if done else 'not taken'}: “{said}”")
        if not done and isinstance(scene.do, Move):
            changed = picture.began is not None and picture.design[scene.do.knobs[0]] != picture.began[scene.do.knobs[0]]
            found.hold(f"{what}, said", bool(said) == changed, f"{here}: “{said}”")
            found.hold(f"{what}, asked again", 'class="ol-todo">' in card_html(picture, "hand"), f"{here}: the request is grey")
        if not done:
            found.hold(f"{what}, no praise", not PRAISE.search(said), f"{here}: “{said}”")


def ways(scene: Any, options: int) -> Iterator[tuple[str, int]]:
    """What may be done as asked: each option, or the action."""
    if isinstance(scene.do, Choose):
        yield from ((f"option {k + 1}", k) for k in range(options))
    elif scene.answers:
        yield "done", 0


def judged(lesson: Lesson, walker: Walker, found: Cards, here: str) -> None:
    """The verdict's numbers are those of its design, computed anew; its verdict words are true by a witness of Law B."""
    picture = walker.session.picture
    assert picture is not None and picture.scene is not None
    kept = picture.state.done[picture.scene.id]
    outcome = lesson.compute(kept)
    say = picture.scene_words.say
    said = verdict(walker)
    for name in places_of(say):
        value = {**dict(outcome.design.values), **outcome.metrics}.get(name)
        held = {**dict(picture.kept.design.values), **picture.kept.metrics}.get(name) if picture.kept is not None else None
        same = value == held or (isinstance(value, float) and isinstance(held, float) and abs(value - held) <= 1e-9 * abs(value))
        found.hold("numbers", same or (value != value and held != held), f"{here}: {name} is {held}, computed anew {value}")
    for part in re.split(r"(?<=[.;!?]) (?=[A-Z])", said):
        if not words_in(part):
            continue
        one = Said(lesson, outcome, "card", part, None)
        match = next(((w, m) for w in witnesses() if (m := w.sees(one))), None)
        if match is None or match[0].judge is None:
            continue
        try:
            match[0].judge(one, match[1])
            held_true, why = True, ""
        except AssertionError as lie:
            held_true, why = False, str(lie)[:200]
        found.words.update(words_in(part))
        found.hold("verdict words", held_true, f"{here}: “{part}” ← {why}")


def undone(walker: Walker, told: str, found: Cards, here: str) -> None:
    """After undo the verdict speaks of its own run, says that the knobs have changed, and leads back to that run."""
    picture = walker.session.picture
    assert picture is not None
    if not picture.state.can_undo:
        return
    done = picture.design
    walker.send(Undo(), 0.5)
    picture = walker.session.picture
    assert picture is not None
    found.hold("undo", verdict(walker) == told and phrases.SHOW_KEPT.id in verdict_html(picture, "hand"),
               f"{here}: “{verdict(walker)}” for “{told}”")
    walker.send(ShowKeptRun(), 0.5)
    picture = walker.session.picture
    found.hold("that run again", verdict(walker) == told and picture is not None and picture.design == done,
               f"{here}: “{verdict(walker)}” for “{told}”")


def come_back(lesson: Lesson, walker: Walker, index: int, found: Cards, here: str) -> None:
    """By every way back the card says the same of the same run."""
    told = verdict(walker)
    found.hold("verdict", bool(told), f"{here}: says nothing")
    undone(walker, told, found, here)
    step = 1 if index < len(lesson.path) - 1 else -1
    walker.send(TurnScene(step), 0.5)
    walker.send(TurnScene(-step), 0.5)
    found.hold("Next and Back", verdict(walker) == told, f"{here}: “{verdict(walker)}” for “{told}”")
    kept = walker.session._show.view.kept  # type: ignore[attr-defined]
    fresh = Walker.__new__(Walker)
    fresh.now = walker.now
    fresh.session = Session(LESSONS, FakeView(kept), lesson.id, clock=lambda: fresh.now, mode="guide")
    fresh.session.restore(kept)
    fresh.session.open()
    found.hold("reload", verdict(fresh) == told, f"{here}: “{verdict(fresh)}” for “{told}”")
    walker.send(SetLanguage("zh"), 0.3)
    other = verdict(walker)
    walker.send(SetLanguage("en"), 0.3)
    found.hold("other language", verdict(walker) == told != other, f"{here}: “{verdict(walker)}” for “{told}”; “{other}”")
    walker.send(SetMode("lab"), 0.3)
    walker.send(SetMode("guide"), 0.3)
    found.hold("view", verdict(walker) == told, f"{here}: “{verdict(walker)}” for “{told}”")
    picture = walker.session.picture
    assert picture is not None
    linked = Walker(lesson.id)
    linked.session.restore(None)
    linked.send(OpenState(write_token(picture.lesson, walker.session._show.saved())), 0.3)
    found.hold("link", verdict(linked) == told, f"{here}: “{verdict(linked)}” for “{told}”")
    walker.send(RestartScene(), 0.3)
    if not isinstance(lesson.path[index].do, Read):
        found.hold("anew", not verdict(walker), f"{here}: still “{verdict(walker)}”")


def done_right(lesson: Lesson, index: int, found: Cards) -> None:
    """Each option and the action as asked: true, and the same by every way back."""
    scene = lesson.path[index]
    options = len(prediction_of(lesson, scene, "en").options) if isinstance(scene.do, Choose) else 0
    for what, option in ways(scene, options):
        walker = opened(lesson, index)
        asked = question(walker)
        if isinstance(scene.do, Choose):
            walker.send(ChooseOption(option), 3.0)
        else:
            walker.do()
        walker.wait(12.0)
        here = f"{lesson.id} {scene.id} {what}"
        done = scene.id in walker.done
        found.hold(what.split()[0], done, f"{here}: not taken")
        if done and isinstance(scene.do, Choose):
            found.hold("question", question(walker) == asked, f"{here}: was “{asked}”, is “{question(walker)}”")
        if done:
            judged(lesson, walker, found, here)
            come_back(lesson, walker, index, found, here)


def walked(lesson: Lesson, scenes: range | None = None) -> Cards:
    """All that a hand may do in these scenes of a lesson's path."""
    found = Cards()
    for index in scenes or range(len(lesson.path)):
        entered(lesson, index, found)
        wronged(lesson, index, found)
        done_right(lesson, index, found)
    return found


def main(names: list[str]) -> None:
    """Print what was tried and what was false, lesson by lesson."""
    total, false = 0, 0
    for name in names or LESSONS:
        found = walked(LESSONS[name])
        total, false = total + found.tried.total(), false + len(found.false)
        print(f"{name:18s} {found.tried.total():5d} tried, {len(found.false):3d} false: "
              + ", ".join(f"{what} {count}" for what, count in sorted(found.tried.items())), flush=True)
        for line in found.false:
            print("   FALSE " + line[:600], flush=True)
    print(f"{total} states and sentences tried, {false} false")


if __name__ == "__main__":
    main(sys.argv[1:])
