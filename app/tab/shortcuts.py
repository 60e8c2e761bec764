"""The one table that keys, the palette and the list of keys are made from."""

from __future__ import annotations

from dataclasses import dataclass

from ..text.words import Text
from .commands import (
    ChangeSpeed,
    CheckNextTask,
    Command,
    Kick,
    LookFrom,
    Play,
    Redo,
    Reset,
    Rewind,
    RunJob,
    SetLanguage,
    ToggleHelp,
    ToggleLandscape,
    ToggleLecture,
    TurnPage,
    Undo,
)


@dataclass(frozen=True)
class Shortcut:
    """A command that has a key; `key` and `modifier` are what the browser listens to."""

    label: Text
    command: Command
    key: str
    modifier: str | None = None


SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut(Text("Play or pause", "播放或暂停"), Play(), "space"),
    Shortcut(Text("Kick the plant", "给对象一次冲击"), Kick(), "K"),
    Shortcut(Text("Back to the start of the run", "回到运行起点"), Rewind(), "0"),
    Shortcut(Text("Slower", "放慢"), ChangeSpeed(-1), "S"),
    Shortcut(Text("Faster", "加快"), ChangeSpeed(+1), "F"),
    Shortcut(Text("Undo", "撤销"), Undo(), "Z"),
    Shortcut(Text("Redo", "重做"), Redo(), "Y"),
    Shortcut(Text("Reset the lesson's knobs", "把本课旋钮重置为初始值"), Reset(), "R"),
    Shortcut(Text("Next lesson", "下一课"), TurnPage(+1), "N"),
    Shortcut(Text("Previous lesson", "上一课"), TurnPage(-1), "P"),
    Shortcut(Text("Chinese / English", "中文 / 英文"), SetLanguage(), "L"),
    Shortcut(Text("Lecture mode: large print", "讲堂模式：大字号"), ToggleLecture(), "M"),
    Shortcut(Text("Landscape of |det(sI − A + LC)|⁻¹", "|det(sI − A + LC)|⁻¹ 的曲面"), ToggleLandscape(), "G"),
    Shortcut(Text("View everything", "全景"), LookFrom("all"), "1"),
    Shortcut(Text("View the plant", "查看对象"), LookFrom("plant"), "2"),
    Shortcut(Text("View the boards", "查看极点板"), LookFrom("boards"), "3"),
    Shortcut(Text("Start or cancel the long computation", "开始或取消长计算"), RunJob(), "J"),
    Shortcut(Text("Check the first unsolved task", "检查第一个未完成的任务"), CheckNextTask(), "T"),
    Shortcut(Text("This list", "显示本列表"), ToggleHelp(), "H"),
)
