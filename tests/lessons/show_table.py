"""Print for each lesson what its path shows: questions with a figure, those drawn by hand, the first touch, scenes without a picture.

`python tests/lessons/show_table.py`
"""

from __future__ import annotations

from dataclasses import dataclass

from observer_lab.course.guiding.questions import Asked
from observer_lab.course.lesson import Lesson
from observer_lab.course.scenes import Choose, Move, Press, Solve, entry_values
from observer_lab.lessons import LESSONS


@dataclass(frozen=True)
class Row:
    """`drawn` of all `questions` have a figure, `by_hand` of them take a drawing; a knob, a pole or the plant is first moved in scene
    `touch`, counted from 1, after so many `words`; `bare` scenes show neither figure, board nor something that the page performs."""

    lesson: str
    questions: int
    drawn: int
    by_hand: int
    touch: int
    words: int
    bare: int


def row(lesson: Lesson) -> Row:
    """What the path of a lesson shows."""
    path, start, said = lesson.path, lesson.start(), lesson.words["en"].scenes
    asking = [(k, scene) for k, scene in enumerate(path) if isinstance(scene.do, Choose)]
    drawn = [(k, scene) for k, scene in asking if scene.id in lesson.questions]
    by_hand = 0
    for k, scene in drawn:
        entry = lesson.apply(start, entry_values(path, k, start))
        outcomes = (lesson.compute(entry), lesson.compute(lesson.apply(entry, scene.play)))
        by_hand += bool(lesson.questions[scene.id](Asked(lesson, *outcomes)).columns)
    touch = next(k for k, scene in enumerate(path) if isinstance(scene.do, (Move, Solve)) or scene.do == Press("pull"))
    words = sum(len(said[scene.id].text.split()) + len(said[scene.id].do.split()) for scene in path[:touch + 1])
    bare = sum(not (scene.figures or scene.boards or scene.play or scene.id in lesson.questions or isinstance(scene.do, Move)
                    or scene.do == Press("pull")) for scene in path)
    return Row(lesson.id, len(asking), len(drawn), by_hand, touch + 1, words, bare)


def main() -> None:
    """Print the table and its sums."""
    rows = [row(lesson) for lesson in LESSONS.values()]
    print(f"{'lesson':18} questions drawn by hand  first touch: scene, words  bare scenes")
    for each in rows:
        print(f"{each.lesson:18} {each.questions:9} {each.drawn:5} {each.by_hand:7} {each.touch:19} {each.words:6} {each.bare:12}")
    print(f"{'all':18} {sum(r.questions for r in rows):9} {sum(r.drawn for r in rows):5} {sum(r.by_hand for r in rows):7} "
          f"{sum(r.touch <= 2 for r in rows):12} by scene 2 {sum(r.bare for r in rows):9}")


if __name__ == "__main__":
    main()
