"""The README's section for lecturers, followed to the letter: serve, hand in by a page, regenerate, grade."""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

from client import WireTab
from served import Served

from observer_lab.cli.courses import course_in
from observer_lab.page.words.phrases import NOT_HANDED_IN

README = Path(__file__).parents[2] / "README.md"
TOKEN = re.compile(r'data-text="([^"]+)"')


def section() -> tuple[str, list[str]]:
    """The course file and the commands of the section."""
    words = README.read_text(encoding="utf-8").partition("## A course with hand-ins\n")[2].partition("\n## ")[0]
    blocks = dict(re.findall(r"```(toml|sh)\n(.+?)```", words, re.S))
    return blocks["toml"], blocks["sh"].splitlines()


def shown_tokens(tab: WireTab) -> list[str]:
    return [found for widget in tab.widgets.values() for found in TOKEN.findall(str(widget["props"].get("content")))]


def test_the_section_for_lecturers_works_as_it_stands(tmp_path: Path) -> None:
    file, (draw, words, serve, variant, grade) = section()
    file = re.sub(r"deadline = \d{4}", "deadline = 2999", file)  # the date of the README passes
    (tmp_path / "filtering-2026.toml").write_text(file, encoding="utf-8")
    surroundings = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}

    def told(line: str) -> str:
        done = subprocess.run(line, shell=True, cwd=tmp_path, env=surroundings, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    told(draw)
    secret = (tmp_path / "filtering-2026.secret").read_text(encoding="utf-8").strip()
    (tmp_path / "keys.txt").write_text("s1234567\ns7654321\n", encoding="utf-8")
    told(words)
    with (tmp_path / "words.csv").open(encoding="utf-8", newline="") as table:
        word = {row["key"]: row["word"] for row in csv.DictReader(table)}
    answers = {item["item"]: item["answer"] for item in json.loads(told(f"{variant} --json"))["items"]}
    assert "## " in told(variant) and secret not in told(variant)
    with Served(serve.split(), cwd=tmp_path, env=surroundings, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            url = next(line.strip() for line in server.stdout if line.startswith("http://"))
            with WireTab(url) as tab:
                tab.update("your key", value="s1234567")
                tab.answered()  # a new key brings new numbers and an empty field
                tab.update("your word", value=word["s1234567"])
                tab.update("answer", value=answers["kalman exam sheet"])  # the first exam of the lesson
                tab.press("hand in")
                tab.until(lambda: shown_tokens(tab), "the hand-in")
                (written,) = shown_tokens(tab)
                left_out = [widget for widget in tab.widgets.values() if NOT_HANDED_IN("en") in str(widget["props"].get("content"))]
                assert not left_out and tab.labels("answer") == 2  # of the lesson's four exams the course names two
                tab.press("Save hand-in")
                tab.until(lambda: any(message["type"].startswith("FileTransfer") for message in tab.messages), "the file")
                said = repr(tab.messages)
        finally:
            server.send_signal(signal.SIGINT)
            assert server.wait(30) == 0
    keys = course_in(str(tmp_path / "filtering-2026.toml")).keys
    assert written in said
    for key in (keys._numbers, keys._signing):
        assert key.hex() not in said and repr(key)[2:-1] not in said
    assert secret not in said
    (tmp_path / "hand-ins").mkdir()
    (tmp_path / "hand-ins" / "s1234567.txt").write_text(written, encoding="utf-8")
    assert "counted: 1" in told(grade)
    with (tmp_path / "grades.csv").open(encoding="utf-8", newline="") as table:
        assert list(csv.DictReader(table)) == [{"ID number": "s1234567", "kalman exam sheet": "5", "kalman exam nis": "-"}]
