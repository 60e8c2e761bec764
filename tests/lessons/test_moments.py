"""Where a run rests after a verdict, the stage shows what the answer has changed, if anything on the stage has."""

from __future__ import annotations

import numpy as np
from laws import holds_for_all
from test_paths import Walker

from observer_lab.course.lesson import Lesson, Stage
from observer_lab.course.scenes import Choose, entry_values
from observer_lab.lessons import LESSONS
from observer_lab.session.commands.guide import ChooseOption, GoToScene

LEAST, DUST = 0.3, 0.02  # of the largest difference of the run; stage units that nobody sees
MOMENTS = 60  # of a run that are compared
SAME = {"hidden-modes surprise", "observability surprise", "saturation surprise"}  # whose right answer is that it goes as before
ASKING = [(lesson, k) for lesson in LESSONS.values() for k, scene in enumerate(lesson.path) if isinstance(scene.do, Choose) and scene.play]


def standing(stage: Stage, t: float) -> dict[str, np.ndarray]:
    """Where each part of plant and ghost stands, how it is turned, how large it is and its colour."""
    k = min(int(np.searchsorted(stage.t, t)), len(stage.t) - 1)
    twins = {part.name for part in stage.body.parts if part.twin}
    found = {}
    for which, states in (("plant", stage.x), ("ghost", stage.xhat)):
        if states is not None:
            found |= {f"{which} {name}": np.array([*pose.position, *(0.5 * v for v in pose.wxyz), *pose.scale,
                                                   *(v / 255 for v in pose.colour or (0, 0, 0))])
                      for name, pose in stage.body.pose(states[k].tolist(), stage.body.gain).items() if which == "plant" or name in twins}
    return found


def apart(before: Stage, after: Stage, t: float) -> float:
    """How far the part that differs most stands from where it stood in the run before."""
    one, other = standing(before, t), standing(after, t)
    return max(float(np.linalg.norm(one[name] - other[name])) for name in one.keys() & other.keys())


def test_a_run_rests_after_its_verdict_where_the_difference_is_seen() -> None:
    def law(lesson: Lesson, k: int) -> None:
        scene, start = lesson.path[k], lesson.start()
        entry = lesson.apply(start, entry_values(lesson.path, k, start))
        before, after = (lesson.compute(design).stage for design in (entry, lesson.apply(entry, scene.play)))
        assert before is not None and after is not None
        painted = after.picture is not None and not np.array_equal(before.picture.image, after.picture.image)  # type: ignore[union-attr]
        share = scene.moment if scene.told is None else scene.told
        if share is None or painted or f"{lesson.id} {scene.id}" in SAME:
            return
        end = float(min(before.t[-1], after.t[-1]))
        most = max(apart(before, after, t) for t in np.linspace(0.0, end, MOMENTS))
        here = apart(before, after, share * float(after.t[-1]))
        assert most < DUST or here >= LEAST * most, f"{here:.3g} of {most:.3g}"
    holds_for_all(ASKING, law, lambda lesson, k: f"{lesson.id} {lesson.path[k].id}")


def test_an_answered_scene_rests_at_the_moment_of_its_verdict_in_motion_and_in_calm() -> None:
    def law(lesson: Lesson, k: int) -> None:
        scene = lesson.path[k]
        walker = Walker(lesson.id)
        walker.send(GoToScene(k))
        picture = walker.session.picture
        assert picture is not None and (scene.moment is None or picture.state.t == scene.moment * picture.end)
        walker.send(ChooseOption(0))
        walker.wait(3.0 + 1.1 * picture.horizon / picture.rate)
        picture = walker.session.picture
        assert picture is not None and scene.id in picture.state.done and not picture.state.playing
        assert picture.state.t == scene.told * picture.end  # type: ignore[operator]
    holds_for_all([(lesson, k) for lesson, k in ASKING if lesson.path[k].told is not None], law,
                  lambda lesson, k: f"{lesson.id} {lesson.path[k].id}")
