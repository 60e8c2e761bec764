"""On the Chinese page everything that goes wrong arrives in Chinese, with its numbers and names."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from fakes import BROKEN, Tab, job_of, toy

from observer_lab.course.lesson import Design, Outcome
from observer_lab.engine import Plant, lqr, observer_gain, place, to_json
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import RunJob, SetLanguage, UploadPlant

ENGLISH = re.compile(r"[a-z]{3,} [a-z]{2,}")  # two English words in a row
TWO = {"A": [[0, 1], [-2, -3]], "B": [[0], [1]], "C": [[1, 0]]}


def told(tab: Tab) -> str:
    """The one sentence that was said about something bad, as the Chinese page shows it."""
    (text,) = tab.view.scolded()
    said = text(tab.picture.state.language)
    assert not ENGLISH.search(said), said
    return said


def failing(what: object) -> Tab:
    """A Chinese tab whose lesson computes something else as soon as its gain is moved."""
    def compute(design: Design) -> Outcome:
        if design["gain"] != 1.0:
            what()  # type: ignore[operator]
        return toy().compute(design)
    return Tab({"toy": toy(compute=compute)}, language="zh")


@pytest.mark.parametrize("name, content, part", [
    ("mine.json", '{"A": [[NaN]], "B": [[1]], "C": [[1]]}', "文件中含有 NaN"),
    ("mine.json", '{"A": [[1e999]], "B": [[1]], "C": [[1]]}', "A 含有 NaN 或无穷大"),
    ("mine.json", json.dumps({**TWO, "B": [[0, 1]]}), "B 应与 A 一样有 2 行，现为 1×2"),
    ("mine.json", json.dumps({**TWO, "C": [[1, 0, 0]]}), "C 应与 A 一样有 2 列，现为 1×3"),
    ("mine.json", json.dumps({**TWO, "A": [[1, 2]]}), "A 必须是方阵，现为 1×2"),
    ("mine.json", json.dumps({**TWO, "A": [[1, 2], [3]]}), "A 的各行长度必须相同"),
    ("mine.json", json.dumps({**TWO, "A": [["one"]]}), "A 中只能有实数"),
    ("mine.json", json.dumps({**TWO, "states": ["a"]}), "共有 2 个状态，却给了 1 个状态名称"),
    ("mine.json", json.dumps({**TWO, "outputs": [7]}), "outputs 中的每个名称必须是不超过 100 个字符的纯文本"),
    ("mine.json", json.dumps({**TWO, "dt": -1}), "dt 必须是 0（连续时间）或以秒计的正采样周期"),
    ("mine.json", json.dumps({"A": [[1]], "B": [[1]]}), "没有矩阵 C"),
    ("mine.json", "{", "JSON 无法解析"),
    ("mine.txt", "A = 1", "对象则是 .json 或 .mat 文件"),
    ("mine.mat", "MATLAB", "请在 MATLAB 中用 save -v7 保存"),
], ids=lambda v: v[:24])
def test_a_file_that_is_no_plant(name: str, content: str, part: str) -> None:
    tab = Tab(language="zh")
    tab.do(UploadPlant(name, content.encode()))
    assert told(tab).startswith("该文件无法使用：") and part in told(tab)


@pytest.mark.parametrize("what, sentence", [
    (lambda: place([[0, 1], [0, 0]], [[1], [0]], [-1, -2]), "位于 0 的模态不可控：任何 K 都移不动它，请在所求极点中保留 0。"),
    (lambda: observer_gain([[2, 0], [0, -1]], [[0, 1]], [-1, -3]), "位于 2 的模态不可观：任何 L 都移不动它，请在所求极点中保留 2。"),
    (lambda: lqr(np.eye(2), np.eye(2), np.eye(3), np.eye(2)), "Q 应为 2×2 矩阵，现为 3×3。"),
    (lambda: np.linalg.inv(np.zeros((2, 2))), "课程无法计算这一设计（矩阵奇异或迭代不收敛），保留上一幅正确的图。请撤销或调整旋钮。"),
], ids=["uncontrollable", "unobservable", "shape", "library"])
def test_a_design_that_the_engine_refuses(what: object, sentence: str) -> None:
    tab = failing(what)
    tab.set(gain=2.0)
    assert told(tab) == sentence and tab["gain"] == 1.0


def test_an_error_that_nobody_foresaw() -> None:
    tab = Tab(language="zh")
    tab.set(gain=BROKEN)
    assert "除数为零" in told(tab)
    assert "a division by zero" in tab.view.scolded()[0]("en")


def test_a_job_that_fails() -> None:
    def run(outcome: Outcome) -> Iterator[tuple[float, Outcome]]:
        yield 0.5, outcome
        place([[0]], [[0]], [-1])
    tab = Tab({"toy": toy(job=job_of(run))}, language="zh")
    tab.do(RunJob())
    for _ in range(3):
        tab.session.step(0.0)
    assert told(tab) == "位于 0 的模态不可控：任何 K 都移不动它，请在所求极点中保留 0。"


def test_a_sampled_plant_that_no_continuous_one_stands_behind() -> None:
    delay = Plant([[0.0, 1.0], [0.0, 0.5]], [[0.0], [1.0]], [[1.0, 0.0]], dt=0.1)
    tab = Tab({"separation": LESSONS["separation"]}, language="zh")
    tab.do(UploadPlant("mine.json", to_json(delay).encode()))
    assert "：这个采样对象在零处有极点（即纯时延），连续对象不会有这样的极点。请在“沙盒”课中使用它。" in told(tab)


@pytest.mark.parametrize("values", [
    {"gain": float("nan")}, {"gain": 1e9}, {"nobody": 1.0}, {"mode": "c"}, {"poles": [(-1.0, 1.0), (-1.0, 2.0)]},
    {"poles": 3}, {"hand": [(0.0, 1e9)]}, {"hand": "left"},
], ids=lambda v: str(v)[:40])
def test_a_knob_that_refuses(values: dict) -> None:
    tab = Tab(language="zh")
    tab.set(**values)
    assert re.search(r"[\u4e00-\u9fff]", told(tab)) and "that" not in told(tab)


def test_the_english_page_goes_on_in_english() -> None:
    tab = failing(lambda: place([[0, 1], [0, 0]], [[1], [0]], [-1, -2]))
    tab.do(SetLanguage("en"))
    tab.set(gain=2.0)
    assert tab.view.scolded()[0]("en") == "The mode at 0 is uncontrollable: no K can move it, so keep 0 among the requested poles."


def test_the_sandbox_says_in_chinese_why_an_analysis_does_not_apply() -> None:
    """Its refusals stand in captions, not in notifications."""
    unstable = Plant([[1.0, 0.0], [0.0, 2.0]], [[1.0], [0.0]], [[1.0, 0.0]])  # a hidden mode that runs away
    tab = Tab({"sandbox": replace(LESSONS["sandbox"])}, language="zh")
    tab.do(UploadPlant("mine.json", to_json(unstable).encode()))
    captions = [figure.caption("zh") for figure in tab.shown.figures]
    assert any(c.startswith("此处不适用：") for c in captions)
    assert not [c for c in captions if ENGLISH.search(c)]
