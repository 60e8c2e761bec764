"""The columns beside the stage keep their widths, also in a browser that was too busy to hear them."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest

from observer_lab.page.column.column_widths import Columns
from observer_lab.page.viser_private import viser_internals


class Panel:
    def __init__(self) -> None:
        self.told: list[float] = []
        self.gone = False

    def set_width(self, width: float) -> None:
        if self.gone:
            raise RuntimeError("Cannot place a removed PanelHandle.")
        self.told.append(width)


def test_a_column_whose_width_was_forgotten_is_told_again_and_one_that_a_hand_moved_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    heard, done = list[Any](), list[Any]()
    widget = SimpleNamespace(on_update=heard.append, _impl=SimpleNamespace(uuid="w"))
    client: Any = SimpleNamespace(gui=SimpleNamespace(add_number=lambda *_, **__: widget))
    monkeypatch.setattr(viser_internals, "run_script", lambda *_, **__: None)
    right, main, columns = Panel(), Panel(), Columns()
    columns.add(right, 395.0)  # type: ignore[arg-type]
    columns.add(main, 345.0)  # type: ignore[arg-type]
    columns.watch(client, lambda edit: done.append(edit) or len(done), 519.0)
    assert (right.told, main.told) == ([395.0], [345.0])
    for seen, times in ((395, 1), (520, 1), (304, 2), (300, 3)):
        asyncio.run(heard[0](SimpleNamespace(target=SimpleNamespace(value=seen))))
        while done:  # the tab's own thread tells the page
            done.pop().do()
        assert right.told == [395.0] * times and main.told == [345.0]
    for seen, width in ((-2, 519.0), (304, 519.0), (-3, 395.0)):  # wide, forgotten by the browser, as before
        asyncio.run(heard[0](SimpleNamespace(target=SimpleNamespace(value=seen))))
        done.pop().do()
        assert right.told[-1] == width
    right.gone = True
    asyncio.run(heard[0](SimpleNamespace(target=SimpleNamespace(value=304))))
    done.pop().do()
