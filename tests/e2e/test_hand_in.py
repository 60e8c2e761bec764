"""A student in a browser: an answer is handed in, copied, saved, and still there after a reload, in both languages."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path

from playwright.sync_api import Browser
from tab import Tab, eventually

from observer_lab.cli.courses import course_in
from observer_lab.course.handin.grading import grade
from observer_lab.lessons import LESSONS
from observer_lab.page.words import phrases

COURSE = """
course = "course-of-a-test"
secret = "a secret of a course, for tests alone"

[[lessons]]
lesson = "separation"
exams = ["offset"]
"""


def test_an_answer_is_handed_in_copied_and_saved_and_outlives_a_reload(serve: Callable[..., AbstractContextManager[str]], browser: Browser,
                                                                       tmp_path: Path) -> None:
    file = tmp_path / "course.toml"
    file.write_text(COURSE, encoding="utf-8")
    with serve(0, "--lesson", "separation", "--course", str(file)) as address:
        context = browser.new_context(viewport={"width": 900, "height": 560}, reduced_motion="reduce",
                                      permissions=["clipboard-read", "clipboard-write"])
        tab = Tab(context.new_page(), address, drawn=False)
        tab.unfold(phrases.EXAM("en"))
        tab.row("your key").locator("input").fill("s1")
        tab.row("your word").locator("input").fill(course_in(str(file)).keys.word("s1"))
        tab.answered()
        tab.unfold(f"1 {LESSONS['separation'].words['en'].exams['offset'].title}")
        tab.row("answer").locator("input").fill("3")
        tab.answered()
        tab.press("hand in")
        field = tab.page.locator(".ol-link")
        token = eventually(field.input_value, bool, "the hand-in")
        copy = tab.page.locator(".ol-copy")
        copy.click()
        eventually(copy.inner_text, lambda words: words == phrases.COPIED("en"), "the button says that it has copied")
        assert tab.page.evaluate("navigator.clipboard.readText()") == token
        with tab.page.expect_download() as saved:
            tab.press("Save hand-in")
        assert Path(saved.value.path()).read_text(encoding="utf-8") == f"{token}\n"
        assert saved.value.suggested_filename == "separation-exam-offset.hand-in.txt"
        tab.press("中文")
        tab.page.reload()
        tab.page.get_by_text(phrases.EXAM("zh"), exact=True).first.wait_for()  # what was pressed last is done again after the reload
        tab.settle()
        tab.unfold()
        assert eventually(field.input_value, bool, "the hand-in after a reload") == token
        eventually(copy.inner_text, lambda words: words == phrases.COPY_HAND_IN("zh"), "the button in the language that was pressed last")
        assert not tab.complaints
        context.close()
    (found,) = grade(course_in(str(file)), LESSONS, [("", token)])
    assert found.refusal is None and found.hand_in is not None and (found.hand_in.student, found.hand_in.answer) == ("s1", "3")
