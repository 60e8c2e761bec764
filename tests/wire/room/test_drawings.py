"""A class draws a prediction: nothing shows before the end, then the cloud of all drawings, then the run over it."""

from __future__ import annotations

from lecture import Enter, Present, ask, card, counts, number_of_the_vote, say, typed

from observer_lab.classroom.votes import HIDDEN_BELOW
from observer_lab.course.scenes import Choose
from observer_lab.lessons import LESSONS
from observer_lab.page.screen.server import LabServer
from observer_lab.session.commands.guide import GoToScene

PATH = LESSONS["separation"].path
DRAWN = next(k for k, scene in enumerate(PATH) if isinstance(scene.do, Choose) and scene.id in LESSONS["separation"].questions)


def test_a_class_draws_its_prediction_and_sees_the_cloud_then_the_run(enter: Enter, present: Present, server: LabServer) -> None:
    presenter, follower = present(), enter()
    follower.until(lambda: card(follower), "the card")
    server.sessions[max(server.sessions)].post(GoToScene(DRAWN))
    presenter.until(lambda: "vote:sketch" in counts(presenter), "the button that asks for drawings")
    ask(presenter, "vote:sketch")
    vote = number_of_the_vote(follower, "sketch")
    assert 'class="ol-sketch"' in typed(follower) and "<svg" in typed(follower), "the figure to draw into"
    for odd in ("", "nan", "0.5", "1,2,3", ",".join(["2"] * 12), ",".join(["0.5"] * 41), "0.5;0.5"):
        say(follower, f"sketch:{vote}:{odd}:ballot9999")
    say(follower, f"number:{vote}:0.5:ballot9998")
    for k in range(HIDDEN_BELOW):
        say(follower, f"sketch:{vote}:{','.join(f'{(i + k) / 60:.3f}' for i in range(40))}:ballot{k:04d}")
    follower.until(lambda: sum("drawing is counted" in note for note in follower.notes) == HIDDEN_BELOW, "all drawings")
    presenter.until(lambda: f"{HIDDEN_BELOW} votes" in counts(presenter), "the count")
    ask(presenter, "vote:close")
    presenter.until(lambda: f"vote:show:{vote}" in counts(presenter), "the end of the vote")
    assert "ol-drawings" not in typed(follower) + counts(presenter), "nothing before the presenter shows it"
    ask(presenter, f"vote:show:{vote}")
    presenter.until(lambda: any("ol-drawings" in str(widget["props"].get("content")) for widget in presenter.widgets.values()), "the cloud")
    follower.until(lambda: "ol-drawings" in typed(follower), "the cloud for all")
    before = typed(follower)
    assert "ol-right" not in card(follower) + card(presenter), "nothing tells the answer"
    ask(presenter, f"vote:reveal:{vote}")
    follower.until(lambda: "ol-right" in card(follower), "the right option, once it was performed")
    follower.until(lambda: "ol-drawings" in typed(follower) and len(typed(follower)) > len(before), "the run over the cloud")
    ask(presenter, "vote:typed")
    assert number_of_the_vote(follower, "sketch") != vote
