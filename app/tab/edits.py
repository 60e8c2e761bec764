"""Edits and commands: the one table that keys, buttons, the palette and the help list are made from."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..text.words import Text


@dataclass(frozen=True)
class Command:
    """A command that buttons, keys and scripts share; `key` and `modifier` are what the browser listens to."""

    name: str
    label: Text
    key: str | None = None
    modifier: str | None = None
    argument: Any = None


COMMANDS: tuple[Command, ...] = (
    Command("play", Text("Play or pause", "播放或暂停"), "space"),
    Command("kick", Text("Kick the plant", "给对象一次冲击"), "K"),
    Command("rewind", Text("Back to the start of the run", "回到运行起点"), "0"),
    Command("slower", Text("Slower", "放慢"), "S"),
    Command("faster", Text("Faster", "加快"), "F"),
    Command("undo", Text("Undo", "撤销"), "Z"),
    Command("redo", Text("Redo", "重做"), "Y"),
    Command("reset", Text("Reset the lesson's knobs", "把本课旋钮重置为初始值"), "R"),
    Command("next", Text("Next lesson", "下一课"), "N"),
    Command("previous", Text("Previous lesson", "上一课"), "P"),
    Command("language", Text("Chinese / English", "中文 / 英文"), "L"),
    Command("lecture", Text("Lecture mode: large print", "讲堂模式：大字号"), "M"),
    Command("landscape", Text("Landscape of |det(sI − A + LC)|⁻¹", "|det(sI − A + LC)|⁻¹ 的曲面"), "G"),
    Command("camera", Text("View everything", "全景"), "1", None, "all"),
    Command("camera", Text("View the plant", "查看对象"), "2", None, "plant"),
    Command("camera", Text("View the boards", "查看极点板"), "3", None, "boards"),
    Command("run_job", Text("Start or cancel the long computation", "开始或取消长计算"), "J"),
    Command("check_next", Text("Check the first unsolved task", "检查第一个未完成的任务"), "T"),
    Command("help", Text("This list", "显示本列表"), "H"),
)


@dataclass(frozen=True)
class SetKnobs:
    """New values for knobs, as they came in. Edits of one `grip` belong to one drag, and to one step of undo."""

    values: Mapping[str, Any]
    grip: int | None = None


@dataclass(frozen=True)
class Do:
    """A command by name, with an argument if it takes one."""

    name: str
    argument: Any = None


class Mailbox:
    """Edits in order: the latest change of the same knobs replaces an older one, commands stay."""

    def __init__(self) -> None:
        self._edits: list[SetKnobs | Do] = []
        self._ready = threading.Condition()
        self.closed = False

    def post(self, edit: SetKnobs | Do) -> None:
        """Put an edit in; cheap enough for the event loop."""
        with self._ready:
            if isinstance(edit, SetKnobs):
                self._drop_older(edit)
            self._edits.append(edit)
            self._ready.notify()

    def _drop_older(self, edit: SetKnobs) -> None:
        """Forget a waiting change of just the same knobs, if no command came after it."""
        for i in range(len(self._edits) - 1, -1, -1):
            waiting = self._edits[i]
            if not isinstance(waiting, SetKnobs):
                return
            if waiting.values.keys() == edit.values.keys():
                del self._edits[i]
                return

    def take(self, wait: float | None) -> list[SetKnobs | Do]:
        """All edits; waits at most `wait` seconds for the first (None: until one comes or the box is closed)."""
        with self._ready:
            if not self._edits and not self.closed and (wait is None or wait > 0):
                self._ready.wait(wait)
            edits, self._edits = self._edits, []
            return edits

    def empty(self) -> bool:
        """Whether nothing waits."""
        return not self._edits

    def close(self) -> None:
        """Wake the worker up to end."""
        with self._ready:
            self.closed = True
            self._ready.notify()


def grouped(edits: list[SetKnobs | Do]) -> Iterator[list[SetKnobs] | Do]:
    """Neighbouring knob changes together, commands one by one, all in order."""
    waiting: list[SetKnobs] = []
    for edit in edits:
        if isinstance(edit, SetKnobs):
            waiting.append(edit)
            continue
        if waiting:
            yield waiting
            waiting = []
        yield edit
    if waiting:
        yield waiting
