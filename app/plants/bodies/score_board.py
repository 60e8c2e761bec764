"""Stand a board of named bars behind a body, each beside a pale one of full length, with its number."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ...colours import COLOURS
from ...text import Text
from .body import PLANT_COLOUR, STEEL, Body, Box, ErrorMarks, Part, Pose, Rod, Vector, pose_between

LEFT, RIGHT, BEGIN, LONG = -2.15, 2.15, -1.05, 2.0  # x of the board's ends, of where bars begin; how long a bar of 1 is
BEHIND, IN_FRONT, BEFORE, LETTER = 0.85, -1.55, 0.06, 0.1  # y of a board; how far before it bars and words are; half a letter
ROW, FRONT_ROW = 0.26, 0.36  # from one row to the next, behind and in front
EDGE, TITLE, THICK = 0.07, 0.24, 0.17  # above and below all rows, of the title; height of a bar
MOST, LEAST = 1.15, 0.004  # of the full length: the longest and the shortest bar that are drawn
BESIDE, LEG, BELOW = 0.08, 0.035, 0.18  # from the end of a bar to its number; radius of a leg; from a board in front to its title


def with_score_board(body: Body, states: int, names: Sequence[Text], title: Text, said: Callable[[float], str], foot: float,
                     floor: float | None = None) -> Body:
    """The body with a board. After its `states` comes for each row a share of the full length, and the number that is `said`.

    The board begins `foot` high. It stands behind the body on legs from `floor`, without one before the body with its title below.
    """
    title_high, at = (TITLE, BEHIND) if floor is not None else (0.0, IN_FRONT)
    count, row = len(names), ROW if floor is not None else FRONT_ROW
    high = row * count + 2 * EDGE + title_high
    middle, legs = (LEFT + RIGHT) / 2, (LEFT + 0.3, RIGHT - 0.3) if floor is not None else ()
    rows = [foot + high - EDGE - title_high - row * (k + 0.5) for k in range(count)]
    fixed = {"score board": Pose((middle, at, foot + high / 2))}
    fixed |= {f"score leg {k}": pose_between((x, at, floor or 0.0), (x, at, foot)) for k, x in enumerate(legs)}
    fixed |= {f"full bar {k}": Pose((BEGIN + LONG / 2, at - BEFORE / 2, z)) for k, z in enumerate(rows)}

    def end(share: float) -> float:
        return BEGIN + LONG * min(max(share, LEAST), MOST)

    def pose(x: Sequence[float], gain: float) -> Mapping[str, Pose]:
        drawn = {f"score bar {k}": Pose(((BEGIN + end(float(share))) / 2, at - BEFORE, z), scale=(end(float(share)) - BEGIN, 1.0, 1.0))
                 for k, (z, share) in enumerate(zip(rows, x[states:states + count], strict=True))}
        return {**body.pose(x[:states], gain), **fixed, **drawn}

    def marks(x: Sequence[float], xhat: Sequence[float], gain: float) -> ErrorMarks:
        more = ErrorMarks((), ()) if body.marks is None else body.marks(x[:states], xhat[:states], gain)
        shares, numbers = x[states:states + count], x[states + count:states + 2 * count]
        told: tuple[tuple[str, Vector, str], ...] = tuple(
            (said(float(number)), (max(end(float(share)), BEGIN + LONG) + BESIDE, at - 2 * BEFORE, z), "center-left")
            for z, share, number in zip(rows, shares, numbers, strict=True))
        return ErrorMarks(more.bars, (*more.words, *told))

    parts = (*body.parts, Part("score board", Box((RIGHT - LEFT, 0.04, high)), COLOURS["paper"]),
             *(Part(f"score leg {k}", Rod(LEG), STEEL) for k in range(len(legs))),
             *(Part(f"full bar {k}", Box((LONG, 0.02, THICK)), COLOURS["off"]) for k in range(count)),
             *(Part(f"score bar {k}", Box((1.0, 0.03, THICK)), PLANT_COLOUR) for k in range(count)))
    labels = (*((name, ((LEFT + BEGIN) / 2, at - 2 * BEFORE, z + LETTER)) for name, z in zip(names, rows, strict=True)),
              (title, (middle, at - 2 * BEFORE, foot + high - EDGE) if floor is not None else (middle, at - BELOW, 0.0)))
    return replace(body, parts=parts, pose=pose, marks=marks, labels=(*body.labels, *labels),
                   arrows=lambda x, u, gain: body.arrows(x[:states], u, gain), anchors=lambda x, gain: body.anchors(x[:states], gain))
