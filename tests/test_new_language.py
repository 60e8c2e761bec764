"""A new language is one folder: dropped in beside the others it is on the page, and nothing of the page's own stays English."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from catalogues import ROOT
from pseudo import CODE, accented, doubled, prose, write_language

from observer_lab.lessons import LESSONS

LOOK = """
import json, re, sys
from observer_lab.text import languages, name_of
from observer_lab.page.words import phrases
from observer_lab.lessons import LESSONS
from test_chinese_page import FORMULA, KNOWN, page

TOKEN = re.compile(r"[^\\W\\d_]{3,}")

code = sys.argv[1]
left = {}
for lesson in LESSONS.values():
    for words in page(lesson, lesson.start(), code):
        plain = [w for w in TOKEN.findall(FORMULA.sub(" ", words))
                 if w.isascii() and w not in KNOWN and set(w.lower()) & set("aeiou")]
        if plain:
            left.setdefault(lesson.id, []).append(words[:90])
titles = {lesson.id: lesson.words[code].title for lesson in LESSONS.values()}
print(json.dumps({"languages": languages(), "name": name_of(code), "left": left, "titles": titles}))
"""


@pytest.fixture(scope="module")
def locale(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("locale")
    write_language(root)
    return root


def test_the_form_of_a_lesson_survives_translation() -> None:
    assert prose("# Title\n> Why $x$?\n## task a-b: Do {c1}\n- hint\n### solution\nso") == \
        "# Títlé Títlé\n> Whý $x$? Whý $x$?\n## task a-b: Dó {c1} Dó {c1}\n- híñt híñt\n### solution\nšó šó\n"
    assert prose("- is $a > b$\n  > no, $a$\n  goes on") == "- íš $a > b$ íš $a > b$\n  > ñó, $a$ ñó, $a$\n  góéš óñ   góéš óñ\n"
    assert accented("a `code` <b>x</b>") == "á `code` <b>x</b>" and doubled("[m]") == "[m] [m]" and doubled("3") == "3"


@pytest.mark.slow
def test_a_folder_is_a_language(locale: Path) -> None:
    """It names itself, every lesson opens in it, and every word that a lesson brings to the page is its own."""
    env = {**os.environ, "OBSERVER_LAB_LOCALE": str(locale), "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}"}
    done = subprocess.run([sys.executable, "-c", LOOK, CODE], cwd=ROOT, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads(done.stdout)
    assert CODE in found["languages"] and found["name"] == doubled("English")
    assert {key: doubled(lesson.words["en"].title) for key, lesson in LESSONS.items()} == found["titles"]
    assert not found["left"], json.dumps(found["left"], indent=1, ensure_ascii=False)
