"""What an eye would measure, on a few lessons, from a phone to a wall; `python tests/benchmarks/bench_sight.py` measures all of them."""

from __future__ import annotations

import pytest
from sight import HALL, KNOB, MEASURE, TABS, WAITING, look
from tab import Tab, eventually

from observer_lab.lessons import LESSONS, OPENING
from observer_lab.page.charts.print_sizes import SHEET_MAX_WIDTH_PX
from observer_lab.page.words import phrases

WALL = 3840, 2160
OPEN = "() => [...document.querySelectorAll('[role=button][aria-expanded=true]')].map(head => head.textContent)"
BOX = """words => [...document.querySelectorAll('[role=button][aria-expanded]')].find(head => head.textContent === words)?.parentElement"""
BELOW_TOP = f"""words => {{
  const box = ({BOX})(words);
  if (!box) return 1e9;
  const view = box.closest('[data-scrollarea-viewport]'), away = box.getBoundingClientRect().top - view.getBoundingClientRect().top;
  const atEnd = view.scrollTop + view.clientHeight > view.scrollHeight - 2;  // the column is too short to bring it higher
  return atEnd && away > 0 ? 0 : Math.abs(away);
}}"""
SLID = """() => {
  const row = document.querySelector('[data-dock-region=right] [role=tablist]');
  return [row.scrollLeft, row.scrollWidth - row.clientWidth];
}"""
FIGURES = "() => [...document.querySelectorAll('[data-dock-region=right] [data-dock-tab]')].findIndex(tab => tab.ariaSelected === 'true')"


ROOM = """() => {
  const steps = [...Array(24).keys()].map(k => (k + 0.5) / 24);
  const free = steps.flatMap(x => steps.map(y => document.elementFromPoint(x * innerWidth, y * innerHeight)?.tagName === 'CANVAS'));
  const run = [...document.querySelectorAll('.ol-note')].find(note => note.textContent.startsWith('t = ')).getBoundingClientRect();
  const covered = [...document.querySelectorAll('[data-dock-region]')].map(region => region.getBoundingClientRect())
    .some(region => Math.min(region.right, run.right) - Math.max(region.left, run.left) > 1);
  const rows = {}, sheet = document.querySelector('.mantine-Tabs-root:has(.ol-parts)');
  const row = [...document.querySelectorAll('.mantine-Flex-root')]
    .find(each => each.querySelectorAll(':scope > .mantine-Button-root').length > 6);
  for (const {offsetTop, offsetHeight} of row.children) if (offsetHeight) rows[offsetTop] = (rows[offsetTop] ?? 0) + 1;
  return {head: (sheet?.offsetHeight ?? 0) / innerHeight, rows: Object.values(rows), beyond: row.scrollWidth - row.clientWidth,
    free: free.filter(Boolean).length / free.length, covered};
}"""


def test_the_stage_keeps_its_room_in_windows_of_every_shape_and_the_run_is_small_and_lies_on_nothing(tab: Tab) -> None:
    """Projectors, tablets either way round, phones either way round, a laptop's page at twice its size."""
    for across, up in ((1024, 768), (768, 1024), (844, 390), (320, 568), (683, 384), (1366, 1024), (900, 560)):
        tab.page.set_viewport_size({"width": across, "height": up})
        eventually(lambda: tab.page.evaluate(ROOM), lambda room: room["free"] >= 0.25 and not room["covered"] and room["head"] <= 0.5
                   and max(room["rows"]) - min(room["rows"]) <= 1 and room["beyond"] <= 1,
                   f"room for the stage in {across}×{up}")


@pytest.mark.parametrize("name, size, large", [
    ("separation", (1366, 768), True), ("weak-states", (390, 844), False)], ids=str)
def test_the_first_knob_is_in_view_and_words_are_large_enough(walking: Tab, name: str, size: tuple[int, int], large: bool) -> None:
    tab, words = walking, LESSONS[name].words["en"]
    tab.open_lesson(words.title, words.question, size)
    if large:
        tab.press("large print")
    tab.predict("skip")
    tab.reveal()  # until then the prediction has the knobs' room
    seen = eventually(lambda: look(tab, large), lambda it: (it.knob, it.hall, it.cut, it.over) == ("", (), (), ()),
                      "knobs in view, the hall's layout and nothing cut, once the page stands after the answer")
    if large:
        assert seen.one_over <= 50.0, f"{seen.smallest}: {seen.words} px"
        tab.page.set_viewport_size({"width": WALL[0], "height": WALL[1]})
        tab.answered(rests=True)
        eventually(lambda: look(tab, large), lambda it: it.one_over <= 50.0 and (it.knob, it.hall, it.cut) == ("", (), ()),
                   "a page for a wall, once it has its new size")
        heads = tab.page.locator("[data-dock-region=right] [data-dock-tab]")
        for k in range(1, heads.count()):  # short figures and charts fill the column
            heads.nth(k).click()
            eventually(lambda: look(tab, large).hall, lambda faults: not faults, f"the figures of {heads.nth(k).inner_text()}")
        for key in "oeh":  # the dialogs: all lessons, take it with you, the keys
            tab.key(key)
            tab.page.wait_for_selector(".mantine-Modal-content")
            seen = look(tab)
            assert seen.one_over <= 50.0, f"{key}: {seen.smallest}: {seen.words} px"
            tab.key(key)
            tab.page.wait_for_selector(".mantine-Modal-content", state="detached")
    if size[0] < 576:
        assert seen.screens <= 2.0, "a part of the lesson takes more than one screen of scrolling"
        assert seen.words >= 10.0, f"{seen.smallest}: {seen.words} px"
    if large:
        tab.press("large print")


@pytest.mark.parametrize("name, language", [("showdown", "en"), ("fault-diagnosis", "zh")])
def test_tabs_stand_in_one_row_that_shows_the_chosen_one_and_no_figure_is_cut(walking: Tab, name: str, language: str) -> None:
    tab, words = walking, LESSONS[name].words
    tab.open_lesson(words["en"].title, words["en"].question, (1366, 768))
    if tab.page.locator(".ol-veil").count():
        eventually(lambda: tab.page.evaluate(WAITING), lambda hidden: not hidden, "all sentences of a prediction before the knobs")
        tab.predict("skip")
        tab.reveal()
    tab.page.set_viewport_size({"width": 1920, "height": 1080})
    if language == "zh":
        tab.press("中文")
    tab.key("m")
    heads = tab.page.locator("[data-dock-region=right] [data-dock-tab]")
    assert heads.count() > 5
    for k in (*range(heads.count()), 0):
        heads.nth(k).click()
        eventually(lambda: (*tab.page.evaluate(TABS), *tab.page.evaluate(HALL), *tab.page.evaluate(MEASURE)["cut"]),
                   lambda faults: not faults, f"the row of tabs and their figures with {heads.nth(k).inner_text()} chosen")
    tab.page.locator("[data-dock-region=right] [role=tablist]").hover()
    before = tab.page.evaluate(SLID)
    tab.page.mouse.wheel(0, 120)
    eventually(lambda: tab.page.evaluate(SLID), lambda at: at[0] > before[0] or at[1] <= 1, "a wheel slides the row where it is too long")
    tab.key("m")
    tab.page.set_viewport_size({"width": 1366, "height": 768})
    heads.last.click()
    eventually(lambda: tab.page.evaluate(TABS), lambda faults: not faults, "the row of tabs in normal print")
    heads.first.click()
    for high in (1600, 768):
        tab.page.set_viewport_size({"width": 1366, "height": high})
        eventually(lambda: tab.page.evaluate(MEASURE), lambda seen: seen["empty"] < 0.2 and not seen["cut"],
                   f"charts in normal print take what the column has left at {high} px")
    assert tab.page.evaluate(KNOB, SHEET_MAX_WIDTH_PX) == "", "all knobs that are turned often stand in their box"


def test_folders_scroll_and_the_chosen_figure_survive_language_and_print(walking: Tab) -> None:
    tab, words = walking, LESSONS[OPENING].words["en"]
    tab.open_lesson(words.title, words.question)

    def by_hand(language: str) -> tuple[set[str], set[str], str]:
        """What is opened, what is closed, and what stands at the top of the column."""
        timeline = phrases.TIMELINE(language)
        return {timeline, LESSONS[OPENING].words[language].steps[1][0]}, {phrases.KNOBS(language)}, timeline

    def stands(language: str) -> None:
        opened, closed, top = by_hand(language)
        eventually(lambda: set(tab.page.evaluate(OPEN)), lambda seen: opened <= seen and not closed & seen, f"folders in {language}")
        eventually(lambda: tab.page.evaluate(BELOW_TOP, top), lambda away: away < 3, f"the column's scroll in {language}")
        eventually(lambda: tab.page.evaluate(FIGURES), lambda chosen: chosen == 1, f"the figure in {language}")
    if tab.page.locator(".ol-veil").count():
        tab.predict("skip")
    opened, closed, top = by_hand("en")
    for name in (*opened, *closed):
        tab.page.evaluate(f"words => ({BOX})(words).firstElementChild.click()", name)
    tab.page.locator("[data-dock-region=right] [data-dock-tab]").nth(1).click()
    eventually(lambda: set(tab.page.evaluate(OPEN)), lambda seen: opened <= seen and not closed & seen, "folders as the hand left them")
    eventually(lambda: (tab.page.evaluate(f"words => ({BOX})(words).scrollIntoView()", top), tab.page.evaluate(BELOW_TOP, top))[1],
               lambda away: away < 3, "the column scrolled by hand, when nothing opens or closes any more")
    stands("en")
    for key, language in (("l", "zh"), ("m", "zh"), ("l", "en")):
        tab.key(key)
        stands(language)
    for key in "lm":  # at once: the second change begins in the middle of the first
        tab.key(key)
    stands("zh")
    tab.key("l")
