"""One browser tab on the app, with the words a test needs: choose, slide, read curves, wait."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from typing import Any, TypeVar

from playwright.sync_api import Error, Locator, Page

from observer_lab.lessons import LESSONS, OPENING
from observer_lab.page.words import phrases

FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync",
         "--enable-unsafe-swiftshader", "--disable-gpu-compositing"]
PATIENCE = 60.0  # s: software rendering on a busy machine is slow, and a test that waits is not a test that fails
HARMLESS = (
    "GPU stall", "GroupMarkerNotSet",  # said by software rendering
    "passive event listener",  # said by the page's own sliders whatever they show
    "non-existent component",  # viser applies the updates of a batch after the removals of the same batch
)

CURVES = """() => Object.values(window.__viserTestpoints?.uplots ?? {})
  .filter(u => u.chart.root.isConnected)
  .map(u => [u.chart.root.querySelector('.u-title')?.textContent ?? '', Array.from(u.chart.data, row => Array.from(row))])"""
DRAWINGS = "() => Array.from(document.querySelectorAll('.ol-figure'), f => f.innerHTML)"
ANSWERED = """async rests => {
  const wait = ms => new Promise(done => setTimeout(done, ms)), end = performance.now() + 2000;
  const question = window.observerLabQuestion = (window.observerLabQuestion ?? 0) + 1;
  await wait(60);  // the page keeps back what is done within 50 ms of the last message; timers of one page run in order
  for (let asked = ''; performance.now() < end; await wait(10)) {
    const mark = document.querySelector('.ol-mark')?.dataset;
    if (!mark) continue;
    if (mark.ask !== asked) {  // also where the page was laid out anew, and the question went with the old one
      asked = mark.ask;
      window.__viserMutable.sendMessage({type: 'GuiUpdateMessage', uuid: asked, updates: {value: question}});
    }
    if (Number(mark.answer) < question || (rests && mark.rests !== '1')) continue;
    await new Promise(done => requestAnimationFrame(() => setTimeout(done)));  // what React does after it has drawn
    return true;
  }
  const marks = Array.from(document.querySelectorAll('.ol-mark'), mark => JSON.stringify({...mark.dataset}));
  const page = window.__viserMutable, root = page?.scene?.__r3f?.root.getState();
  return `question ${question}, ${marks.length} marks ${marks}, page ${document.visibilityState}, ${page?.messageQueue.length} messages `
    + `wait, ${page?.messageQueue.slice(0, 5).map(m => m.type)}, ${page?.getRenderRequestState}, frames ${root?.internal.frames} `
    + `${root?.internal.active} ${root?.frameloop}`;
}"""
DRAWN = """() => new Promise(done => {
  const page = window.__viserMutable, seen = page.scene.onAfterRender;
  let frames = 0;
  const end = drawn => { clearTimeout(late); page.scene.onAfterRender = seen; done(drawn); };
  const late = setTimeout(() => end(frames > 0), 2000);  // a browser that never draws sharply has drawn all the same
  page.scene.onAfterRender = (...all) => {
    seen(...all);
    frames += 1;
    if (page.scene.__r3f.root.getState().viewport.dpr >= devicePixelRatio) end(true);
  };
  page.requestRender();
})"""
UNDRAWN = """() => {  // the scene is built, moved and picked as ever, but its frames cost nothing until a picture is wanted
  const pen = WebGL2RenderingContext.prototype;
  for (const name of ['clear', 'drawArrays', 'drawArraysInstanced', 'drawElements', 'drawElementsInstanced']) {
    const draw = pen[name];
    pen[name] = function (...how) { if (window.observerLabDraws) draw.apply(this, how); };
  }
}"""
UNFOLD = """words => {  // a folder by its head, or all of them; whether they stand open
  const heads = [...document.querySelectorAll('.mantine-Paper-root > .mantine-Paper-root:has(> svg[class*="chevron"])')]
    .filter(head => head.lastElementChild.checkVisibility() && (words === null || head.textContent.trim() === words));
  const closed = heads.filter(head => head.lastElementChild.matches('[class*="chevron-down"]'));
  closed.forEach(head => head.click());
  return heads.length > 0 && closed.length === 0;
}"""
UNFOLD_QUESTION = """() => {  // the folder below the word that there is a question; whether its options stand
  const room = document.querySelector('.ol-veil')?.closest('div:has(+[data-ol-folder])');
  if (!document.querySelector('.ol-option:enabled')) room?.nextElementSibling.querySelector('[role=button][aria-expanded=false]')?.click();
  return document.querySelectorAll('.ol-option:enabled').length > 0;
}"""
FORGET = """() => {
  Object.assign(window.observerLabKeep, {lesson: '', hand: {}});
  [...document.querySelectorAll('button')].find(button => button.textContent.startsWith('forget all')).click();
}"""
ON_BODY = "() => { document.body.tabIndex = -1; document.body.focus(); document.body.removeAttribute('tabindex'); }"
ON_TOP = "() => document.querySelectorAll('[data-scrollarea-viewport]').forEach(view => { view.scrollTop = 0; })"
CLOSE = re.compile("^(close|关闭)$")
MORE = re.compile("^(more|更多)( knobs|旋钮)?$")
DISMISS = """() => {
  document.querySelectorAll('.mantine-Notification-closeButton').forEach(button => button.click());
  return Array.from(document.querySelectorAll('.mantine-Notification-root'), notice => notice.innerText).join(' | ');
}"""
HELD_BACK = "() => new Promise(done => setTimeout(done, 60))"
T = TypeVar("T")


def eventually(look: Callable[[], T], wanted: Callable[[T], Any], what: str, patience: float = PATIENCE) -> T:
    """The first value of `look` that is `wanted`; fails with the last one seen.

    While the page is laid out anew, for a language or a size of print, what is looked at may be gone for a moment.
    """
    deadline = time.monotonic() + patience
    while True:
        try:
            seen: Any = look()
            if wanted(seen):
                return seen
        except Error as gone:
            seen = gone
        assert time.monotonic() < deadline, f"{what}: not within {patience:g} s; last seen {str(seen)[:300]}"
        time.sleep(0.03)


class Tab:
    """A page of the app in its own browser context; its scene is drawn by the processor, or only for pictures."""

    def __init__(self, page: Page, address: str, drawn: bool = True) -> None:
        self.page, self.address = page, address
        self.complaints: list[str] = []
        if not drawn:
            page.add_init_script(f"({UNDRAWN})()")
        page.set_default_timeout(PATIENCE * 1000)
        page.on("pageerror", lambda error: self.complaints.append(error.stack or str(error)))
        page.on("console", lambda m: self.complaints.append(m.text)
                if m.type == "error" and not any(word in m.text for word in HARMLESS) else None)
        page.on("request", lambda request: self._asked(request.url))
        self.open()

    def _asked(self, url: str) -> None:
        """Whatever a page asks for, it asks of its own server."""
        if not url.startswith((self.address.partition("#")[0], "data:", "blob:")):
            self.complaints.append(f"a request left the server's host: {url[:200]}")

    # --- opening ---------------------------------------------------------------------------------------------------
    def open(self) -> None:
        """Load the page and wait until its lesson stands."""
        self.page.goto(self.address)
        self.settle()
        self.close_any_notices()

    def begin_anew(self, width: int, height: int) -> None:
        """Make the page as it was when it was opened, without loading it: the lab forgets all, as its own button does."""
        self.page.set_viewport_size({"width": width, "height": height})
        eventually(self.close_a_dialog, lambda left: left == 0, "dialogs closed")
        if self.language() != "en":
            self.press("English")
        words = LESSONS[OPENING].words["en"]
        self.choose_lesson(words.title, words.question)
        self.unfold(phrases.MY_DESIGNS("en"))
        self.page.evaluate(FORGET)
        eventually(self.page.locator(".ol-veil").count, bool, "a lesson that waits for a prediction")
        self.page.evaluate(ON_BODY)
        self.key("1")
        self.settle()
        self.close_any_notices()
        self.page.evaluate(ON_TOP)

    def settle(self) -> None:
        """Wait until the question and at least one figure are there and all is answered and at rest."""
        self.page.wait_for_selector(".ol-question")
        self.answered(rests=True)
        eventually(self.shown, lambda shown: shown != "[[], []]", "a figure")

    def close_any_notices(self) -> None:
        """Dismiss the notifications that are there, that of software rendering among them, and one that comes meanwhile."""
        eventually(lambda: self.page.evaluate(DISMISS), lambda left: not left, "notices closed")

    def unfold(self, words: str | None = None) -> None:
        """Open the folder under a head, or all there are, those within them too: what was never opened is not built."""
        eventually(lambda: self.page.evaluate(UNFOLD, words), bool, f"the folder {words or 'of any name'} open")

    def close_a_dialog(self) -> int:
        """Close a dialog if one is open; how many there were."""
        dialogs = self.page.locator(".mantine-Modal-content")
        if open_ := dialogs.count():
            dialogs.last.get_by_role("button", name=CLOSE).last.click()
            self.answered()
        return open_

    # --- waiting ---------------------------------------------------------------------------------------------------
    def answered(self, rests: bool = False) -> None:
        """Wait until the page has sent what was done and shows the server's answer to it; its final picture, if asked."""
        eventually(lambda: self.page.evaluate(ANSWERED, rests), lambda said: said is True, "an answer to what was done")

    def sent(self) -> None:
        """Wait until the page has sent what was done, no longer."""
        self.page.evaluate(HELD_BACK)

    def drawn(self) -> None:
        """Wait until the scene, at rest, has been drawn with all its pixels."""
        eventually(lambda: self.page.evaluate(DRAWN), bool, "a drawn scene")

    # --- reading ---------------------------------------------------------------------------------------------------
    def question(self) -> str:
        """The driving question."""
        return self.page.locator(".ol-question").inner_text()

    def in_lab(self) -> bool:
        """Whether the lab stands, from which a page can begin anew; the guide has no driving question."""
        return self.page.locator(".ol-question").count() == 1

    def language(self) -> str:
        """The language of the page, as the browser is told."""
        return self.page.evaluate("document.documentElement.lang")

    def curves(self) -> list[tuple[str, list[list[float]]]]:
        """Title and data rows of each chart over time or frequency that is on the screen."""
        return [(title, rows) for title, rows in self.page.evaluate(CURVES)]

    def shown(self) -> str:
        """Everything that the visible figures draw, to compare with itself."""
        return json.dumps([self.page.evaluate(CURVES), self.page.evaluate(DRAWINGS)])

    def notices(self) -> str:
        """The sentences told to the person."""
        return " ".join(self.page.locator(".mantine-Notification-root").all_inner_texts())

    def equations(self) -> list[str]:
        """The live equations of the left column as text."""
        return self.page.locator(".ol-formula:not(.ol-derived)").all_inner_texts()

    def clock(self) -> float:
        """The time of the run."""
        words = self.page.locator(".ol-note").filter(has_text="t = ").last.inner_text()
        return float(words.split("t = ")[1].split()[0])

    # --- acting: each ends when what it came to is shown, so that nothing of it can arrive later ------------------------
    def button(self, words: str) -> Locator:
        """A button that is seen, by its words; the browser's own search costs a tenth of one by roles, which reads the whole page."""
        return self.page.locator(f'xpath=//button[normalize-space(.)="{words}"]').locator("visible=true")

    def press(self, words: str, rests: bool = True) -> None:
        """Click a button, also one of the menu; `rests=False` where it starts a long job that is to be seen at work."""
        if not self.button(words).count() and self.page.locator(".ol-item", has_text=re.compile(f"^{re.escape(words)}$")).count():
            self.page.locator(".ol-more summary").first.click()
        self.button(words).first.click()
        self.answered(rests)

    def key(self, key: str, times: int = 1, rests: bool = True) -> None:
        """Type a key, and again once it is answered; `rests` as with `press`."""
        for i in range(times):
            self.page.keyboard.press(key)
            self.answered(rests and i == times - 1)

    def quick_keys(self, key: str, times: int) -> None:
        """Type a key as quickly as the page sends what it does, whatever the server is about."""
        for _ in range(times):
            self.page.keyboard.press(key)
            self.sent()

    def choose_lesson(self, title: str, question: str, label: str = "lesson") -> None:
        """Open a lesson from the list under its label."""
        if self.question() != question:
            self.row(label).locator("input").first.click()
            self.page.locator(f'xpath=//*[@role="option"][normalize-space(.)="{title}"]').click()
        eventually(self.question, lambda words: words == question, f"the question of {title}")
        self.settle()

    def open_lesson(self, title: str, question: str, size: tuple[int, int] = (900, 560)) -> None:
        """Open a lesson in English and in a window of some size, wherever the walk has come to."""
        self.page.set_viewport_size({"width": size[0], "height": size[1]})
        if self.language() != "en":
            self.press("English")
        self.choose_lesson(title, question)

    def predict(self, letter: str = "A") -> None:
        """Choose a prediction by pressing its sentence, in the folder that holds it."""
        eventually(lambda: self.page.evaluate(UNFOLD_QUESTION), bool, "the folder of the prediction open")
        option = self.page.locator(f'.ol-option[data-value="{letter}"]').first
        group = f'.ol-option[data-to="{option.get_attribute("data-to")}"]:enabled'
        option.click()
        self.answered(rests=True)
        eventually(lambda: self.page.locator(group).count(), lambda n: n == 0, "the prediction is taken")

    def reveal(self, words: str = "reveal") -> None:
        """See what is so at once, where the run of a prediction is still on its way to its end."""
        self.page.evaluate("""words => [...document.querySelectorAll('button')]
            .find(each => each.checkVisibility() && each.textContent.trim() === words)?.click()""", words)
        eventually(self.button(words).count, lambda n: n == 0, "what is so is revealed")
        self.answered(rests=True)

    def row(self, label: str) -> Locator:
        """The row of a widget by its label, the smallest element that holds label and widget; one that is aside is opened."""
        found = self.page.locator(".mantine-Flex-root", has=self.page.get_by_text(label, exact=True)).last
        more = self.page.locator('[role=button][aria-expanded=false]', has_text=MORE)

        def stands() -> bool:
            if found.count() and found.is_visible():
                return True
            if more.count():
                more.first.click()
                return False
            return found.count() > 0
        eventually(stands, bool, f"the row of {label}, which a page that is being laid out has not yet")
        return found

    def thumb(self, label: str) -> Locator:
        """The handle of a slider by the slider's label."""
        return self.row(label).get_by_role("slider")

    def value(self, label: str) -> float:
        """What a slider's number field shows, as the page itself reads it."""
        return float(self.page.evaluate("words => observerLabFields.read(words, '')", self.row(label).locator("input").last.input_value()))

    def slide(self, label: str, key: str = "ArrowRight", times: int = 3) -> None:
        """Move a slider by keys."""
        self.thumb(label).focus()
        self.key(key, times)

    def type_number(self, label: str, words: str) -> None:
        """Type into a slider's number field, and Enter."""
        field = self.row(label).locator("input").last
        field.fill(words)
        field.press("Enter")
        self.answered(rests=True)

    def picture(self, path: Any) -> None:
        """Keep a screenshot of all that was done, the scene drawn sharp."""
        self.answered(rests=True)
        self.page.evaluate("window.observerLabDraws = true")
        self.drawn()
        try:
            self.page.screenshot(path=path, timeout=PATIENCE * 1000)
        except Error as problem:
            raise AssertionError(f"no screenshot: {problem}") from None
        self.page.evaluate("window.observerLabDraws = false")
