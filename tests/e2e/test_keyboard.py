"""A lesson from the first question to a solved task without touching the mouse."""

from __future__ import annotations

import numpy as np
from tab import Tab, eventually

from observer_lab.course.exercises.exam import seed_of
from observer_lab.lessons import LESSONS
from observer_lab.page.column.knob_widgets import label_of

SLIDER = "stiffness error in the model [%]"
FOCUS = "() => (document.activeElement?.textContent || document.activeElement?.getAttribute('aria-label') || '').trim()"
IS_THUMB = """label => {
  const held = document.activeElement;
  if (held?.getAttribute('role') !== 'slider') return false;
  const name = Array.from(document.querySelectorAll('label')).find(l => l.textContent === label);
  return name !== undefined && held.closest('[id="' + name.htmlFor + '"]') !== null;
}"""
IN_FIELD = """label => {
  const held = document.activeElement;
  if (held?.tagName !== 'INPUT') return false;
  const name = Array.from(document.querySelectorAll('label')).find(l => l.textContent === label);
  return name !== undefined && (held.id === name.htmlFor || held.closest('[id="' + name.htmlFor + '"]') !== null);
}"""
IN_ROW = f"""label => {{  // the field that has the label, or one beside it in a row that has no other
  if (({IN_FIELD})(label)) return true;
  const held = document.activeElement;
  if (held?.tagName !== 'INPUT') return false;
  const rows = Array.from(document.querySelectorAll('.mantine-Flex-root')).filter(row => row.contains(held));
  return rows.some(row => Array.from(row.querySelectorAll('label')).some(l => l.textContent === label)
    && row.querySelectorAll('label').length === 1 && row.querySelectorAll('input').length <= 3);
}}"""
OPTION = "letter => document.activeElement?.matches?.('button.ol-option') && document.activeElement.dataset.value === letter"
EXPANDED = "() => document.activeElement?.getAttribute('aria-expanded')"
ON_PAGE = "() => document.activeElement?.blur()"
RIGHT = """() => [...document.querySelectorAll('.ol-right')]  // among the tasks: a prediction is judged when its run has ended
  .filter(told => document.querySelector('.ol-part-tasks').compareDocumentPosition(told) & Node.DOCUMENT_POSITION_FOLLOWING).length"""
REACH = 110  # presses of Tab within which everything in the left column must be reachable


def walk_to(tab: Tab, there: str, argument: str | None = None, wanted: object = True) -> None:
    """Press Tab until the focus is where it should be."""
    for _ in range(REACH):
        tab.page.keyboard.press("Tab")
        if tab.page.evaluate(there, argument) == wanted:
            return
    raise AssertionError(f"{argument or wanted} is not reached with {REACH} presses of Tab")


def test_the_whole_lesson_by_keyboard_alone(tab: Tab) -> None:
    open_folder(tab, "Predict")
    walk_to(tab, OPTION, "B")
    tab.key("Enter")
    eventually(tab.clock, lambda t: t > 0.0, "the choice of a prediction starts the run")
    walk_to(tab, IS_THUMB, SLIDER)
    before = tab.shown()
    tab.key("ArrowRight", 16)
    eventually(lambda: tab.value(SLIDER), lambda v: v == 16.0, "the arrows move the slider")
    eventually(tab.shown, lambda shown: shown != before, "a curve follows")
    tab.key("t", 2)
    eventually(tab.notices, lambda words: "ratio" in words, "the first task is checked and says what is missing")
    tab.key("z")
    eventually(lambda: tab.value(SLIDER), lambda v: v != 16.0, "undo")
    tab.key("y")
    eventually(lambda: tab.value(SLIDER), lambda v: v == 16.0, "redo")
    tab.key("r")
    eventually(lambda: tab.value(SLIDER), lambda v: v == 0.0, "reset")


def test_playing_by_keys(tab: Tab) -> None:
    tab.predict("B")
    eventually(tab.clock, lambda t: t > 0.0, "a prediction starts the run")
    tab.page.evaluate(ON_PAGE)
    tab.key("Space")
    eventually(lambda: tab.button("▶ play").count(), lambda n: n == 1, "space pauses")
    still = tab.clock()
    tab.answered()
    tab.drawn()
    assert tab.clock() == still
    tab.key("0")
    eventually(tab.clock, lambda t: t == 0.0, "0 goes back to the start")
    before = tab.shown()
    tab.key("k")
    eventually(tab.shown, lambda shown: shown != before, "K kicks the plant")
    eventually(tab.clock, lambda t: t > 0.0, "and plays")
    tab.key("h")
    listed = tab.page.locator(".ol-keys")
    listed.wait_for()
    for label in ("Undo", "Play or pause", "Check the first unsolved task", "Next lesson"):
        assert label in listed.inner_text(), "H lists every key"
    tab.press("close")
    listed.wait_for(state="detached")


def open_folder(tab: Tab, head: str) -> None:
    """Walk to the head of a folder and open it."""
    walk_to(tab, FOCUS, wanted=head)
    tab.key("Enter")
    eventually(lambda: tab.page.evaluate(EXPANDED), lambda state: state == "true", f"{head} opens")


def enter(tab: Tab, label: str, words: str) -> None:
    """Walk to the number field of a label and type into it."""
    tab.page.evaluate(ON_PAGE)
    walk_to(tab, IN_ROW, label)
    tab.page.keyboard.press("Control+a")
    tab.page.keyboard.type(words)
    tab.key("Enter")


def checked(tab: Tab, task: str) -> None:
    """Have the first unsolved task checked, away from any field, and see it solved."""
    tab.page.evaluate(ON_PAGE)
    solved = tab.page.evaluate(RIGHT)
    tab.key("t")
    eventually(lambda: tab.page.evaluate(RIGHT), lambda n: n == solved + 1, f"task {task} solved by keys")


def test_tasks_of_each_kind_and_an_exam_by_keyboard_alone(tab: Tab) -> None:
    """Poles, a choice with a number, and a result that is typed."""
    lesson = LESSONS["virtual-sensor"]
    done = [task for task in lesson.tasks if task.id in ("feel-the-core", "tame-the-runaway", "match")]
    named = {knob.name: label_of(knob, "en") for knob in lesson.knobs}
    after = LESSONS[list(LESSONS)[list(LESSONS).index(lesson.id) + 1]].words["en"]
    tab.choose_lesson(after.title, after.question)
    tab.page.evaluate(ON_PAGE)
    tab.key("p")
    eventually(tab.question, lambda words: words == lesson.words["en"].question, "P opens the lesson before")
    open_folder(tab, "Predict")
    walk_to(tab, OPTION, "ABCD"[lesson.answer])
    tab.key("Enter")
    open_folder(tab, "Tasks")
    for task in done:
        tab.page.evaluate(ON_PAGE)
        tab.key("r")
        for name, value in task.solution.items():
            if name == "plant":
                choose(tab, named[name], dict(lesson.knob(name).options)[value]("en"))  # type: ignore[attr-defined]
            elif name == "observer_poles":
                open_folder(tab, "Observer poles at θ = 1")
                enter(tab, f"{lesson.knob(name).symbol}1", f"{float(np.mean([pole.real for pole in value])):g}")  # the pair's real part
            else:
                enter(tab, named[name], f"{value:g}")
        if task.typed is None:
            checked(tab, task.id)
            continue
        enter(tab, "Your result", task.typed.right(None))
        walk_to(tab, FOCUS, wanted="check")
        tab.key("Enter")
        eventually(lambda: tab.page.evaluate(RIGHT), lambda n: n == len(done), f"task {task.id} typed by keys")
    exam = lesson.exams[0]
    open_folder(tab, "Exam")
    enter(tab, "your key", "me")
    open_folder(tab, f"1 {lesson.words['en'].exams[exam.id].title}")
    enter(tab, "answer", exam.digits.written(exam.item(seed_of("me", lesson.id, exam.id, 1)).answer))
    walk_to(tab, FOCUS, wanted="check")
    tab.key("Enter")
    eventually(lambda: tab.page.evaluate(RIGHT), lambda n: n == len(done) + 1, "the exam")
    choose(tab, "mode", "withheld")
    enter(tab, "answer", "-3")
    walk_to(tab, FOCUS, wanted="note")
    tab.key("Enter")
    eventually(tab.page.get_by_text("Noted: −3.").count, lambda n: n == 1, "an answer that is noted")
    assert tab.page.evaluate(RIGHT) == len(done)


def choose(tab: Tab, label: str, option: str) -> None:
    """Walk to a dropdown and choose by arrows."""
    tab.page.evaluate(ON_PAGE)
    walk_to(tab, IN_FIELD, label)
    for _ in range(8):
        if tab.page.evaluate("() => document.activeElement.value") == option:
            return
        for key in ("ArrowDown", "ArrowDown", "Enter"):
            tab.key(key)
        tab.answered(rests=True)
    raise AssertionError(f"{option} is not among the choices of {label}")


def test_the_keys_of_a_slider_and_of_a_command_leave_the_camera_alone(tab: Tab) -> None:
    where = "() => window.__viserMutable.camera.position.toArray().map(v => v.toFixed(6)).join()"
    tab.drawn()
    still = tab.page.evaluate(where)
    tab.slide(SLIDER, "ArrowRight", 3)
    tab.page.evaluate("document.activeElement.blur()")
    tab.key("s")
    tab.drawn()
    assert tab.page.evaluate(where) == still
    tab.page.keyboard.down("ArrowRight")
    eventually(lambda: tab.page.evaluate(where), lambda at: at != still, "with nothing in focus the arrows turn the view")
    tab.page.keyboard.up("ArrowRight")


def test_another_lesson_is_opened_from_its_card(tab: Tab) -> None:
    tab.key("o")
    cards = tab.page.locator(".ol-cards .ol-do:visible")
    eventually(cards.count, lambda count: count == len(LESSONS), "a card for each lesson")
    walk_to(tab, "id => document.activeElement?.dataset?.value === id", "noise")
    tab.page.keyboard.press("Enter")
    eventually(tab.question, lambda words: words == LESSONS["noise"].words["en"].question, "the lesson of that card")
    eventually(tab.page.locator(".ol-cards").count, lambda count: count == 0, "the page of lessons closes")
    eventually(tab.page.locator(".ol-onward .ol-do").all_inner_texts,
               lambda onward: [words.split(" · ")[1] for words in onward] == [LESSONS[id].words["en"].title for id in ("kalman",)],
               "where one might go on")
