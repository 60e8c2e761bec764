"""Dots, hats and bars above letters stand clear of them at every scale of a screen, in both themes, in formulas and in figures."""

from __future__ import annotations

import re
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page

from observer_lab.colours import palette
from observer_lab.lessons import LESSONS
from observer_lab.page import web
from observer_lab.page.charts.svg import WORDS_PX
from observer_lab.page.words.prose import mathml

BOXES = "[...document.querySelectorAll('p')].map(each => each.getBoundingClientRect()).map(box => [box.top, box.bottom])"
INK = 40  # grey levels from the ground from which on a row holds ink
CLEAR, CLEAR_IN_TEXT = 0.5, 0.65  # of the weaker of accent and letter: what a row between them may hold, in our font and in others
ACCENT = re.compile(r"\\(?:dot|ddot|hat|bar|tilde)(?![a-z])\s*(?:\{\s*\\(?:dot|hat|bar|tilde)\s*\{?\s*[A-Za-z]\s*\}?\s*\}"
                    r"|\{?\\?[A-Za-z]+\}?)")
CARD_PX, FORMULA_PX = 14.5, 15.7  # how large a formula is in the text of a card, and on a line of its own
UNICODE = ("ė", "ẋ", "x̂", "ŷ", "û")  # as the names of curves and axes have them


def accented() -> list[str]:
    """Every accented letter in the words of all lessons, and those that formulas of runs have."""
    found = {r"\dot e", r"\dot x", r"\hat x", r"\dot{\hat x}", r"\bar N", r"\ddot p", r"\hat\tau", r"\tilde Q", r"\dot\theta"}
    for lesson in LESSONS.values():
        prose = lesson.words["en"]
        words = " ".join([prose.introduction, *(text for _, text in prose.steps), *(scene.text for scene in prose.scenes.values())])
        found |= {one.replace("{", "{").strip() for one in ACCENT.findall(words)}
    return sorted(one for one in found if one.count("{") == one.count("}"))


def rows_of(page: Page, pieces: list[str], size: float, dark: bool) -> list[np.ndarray]:
    """For each piece of a page the strongest ink of each row of its pixels, from its first row with ink to its last."""
    colours = palette(dark)
    boxes = "".join(f'<p style="margin:0;padding:9px 20px;width:60px">{piece}</p>' for piece in pieces)
    page.set_content(f"<style>{web.font_rules()} body{{margin:0;background:{colours['page']};color:{colours['ink']};font-size:{size}px;"
                     f"font-family:sans-serif}}</style>{boxes}")
    page.evaluate("document.fonts.ready")
    grey = np.asarray(Image.open(BytesIO(page.screenshot(full_page=True))).convert("L")).astype(float)
    scale = page.evaluate("devicePixelRatio")
    out = []
    for top, bottom in page.evaluate(BOXES):
        part = grey[int(np.floor(top * scale)):int(np.floor(bottom * scale))]
        rows = np.abs(part - grey[0, 0]).max(axis=1)
        inked = np.flatnonzero(rows > INK)
        out.append(rows[inked[0]:inked[-1] + 1])
    return out


def stands_clear(rows: np.ndarray, clear: float = CLEAR) -> bool:
    """Whether a row with little ink parts an accent from what is below it."""
    gaps = [k for k in range(1, len(rows) - 1) if rows[k] < clear * min(rows[:k].max(), rows[k + 1:].max())]
    return any(k <= len(rows) / 2 for k in gaps)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_every_accent_of_a_formula_stands_clear_of_its_letter(browser: Browser, dark: bool) -> None:
    with browser.new_context(device_scale_factor=1) as context:
        page, signs = context.new_page(), accented()
        for size in (CARD_PX, FORMULA_PX):
            drawn = rows_of(page, [mathml(one) for one in signs], size, dark)
            assert [one for one, rows in zip(signs, drawn, strict=True) if not stands_clear(rows)] == []
        assert page.evaluate("[...document.fonts].map(font => font.status)") == ["loaded"]


def test_accents_in_the_names_of_curves_stand_clear(browser: Browser) -> None:
    with browser.new_context(device_scale_factor=1) as context:
        drawn = rows_of(context.new_page(), list(UNICODE), WORDS_PX, False)
        assert [one for one, rows in zip(UNICODE, drawn, strict=True) if not stands_clear(rows, CLEAR_IN_TEXT)] == []


def test_a_missing_dot_is_noticed(browser: Browser) -> None:
    with browser.new_context(device_scale_factor=1) as context:
        assert not any(map(stands_clear, rows_of(context.new_page(), [mathml("e"), mathml("x")], CARD_PX, False)))


@pytest.mark.parametrize("scale", [1, 1.25, 1.5, 2, 3])
def test_dots_and_hats_are_drawn_at_every_scale_of_a_screen(browser: Browser, scale: float) -> None:
    with browser.new_context(device_scale_factor=scale) as context:
        page = context.new_page()
        bare, dot, hat, both = (len(rows) for rows in rows_of(page, [mathml(one) for one in ("x", r"\dot x", r"\hat x", r"\dot{\hat x}")],
                                                              15.0, False))
        assert bare < dot and bare < hat < both
        sizes = page.evaluate("() => [...document.querySelectorAll('mover > mo')].map(mark => getComputedStyle(mark).fontSize)")
        assert set(sizes) == {"15px"}, "a mark in small print can vanish"
