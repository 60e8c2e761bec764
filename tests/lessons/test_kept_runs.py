"""Law A: an answer keeps its run, and whatever a hand does in a scene, its card is true of the state that it shows.

`python -m pytest tests/lessons/test_kept_runs.py --whole` walks every lesson, the suite some of them; `card_law.py` prints the table.
"""

from __future__ import annotations

import pytest
from card_law import walked
from test_paths import PATHS, Walker

from observer_lab.lessons import LESSONS
from observer_lab.session.commands.commands import Undo
from observer_lab.session.commands.guide import GoToScene, RestartScene


@pytest.mark.parametrize("id", PATHS)
def test_every_card_is_true_of_what_it_shows_whatever_a_hand_does(id: str) -> None:
    found = walked(LESSONS[id])
    assert not found.false, "\n".join(found.false)
    assert {"nothing", "verdict", "reload", "link", "other language", "Next and Back"} <= set(found.tried)


def test_undo_stops_where_the_scene_began_and_restart_asks_anew() -> None:
    walker = Walker("separation")
    names = [scene.id for scene in LESSONS["separation"].path]
    walker.send(GoToScene(names.index("drag")), 0.5)
    picture = walker.session.picture
    assert picture is not None
    began = picture.design
    assert not picture.state.can_undo
    walker.do()
    assert walker.session.picture.design != began  # type: ignore[union-attr]
    for _ in range(3):
        walker.send(Undo(), 0.5)
    assert walker.session.picture.design == began  # type: ignore[union-attr]
    walker.send(RestartScene(), 0.5)
    assert "drag" not in walker.done
