"""Show the sliders by which keys or a finger pull the plant; let go, they spring back."""

from __future__ import annotations

import html
import math
import time
from collections.abc import Callable

import viser

from ...course.knobs import ByHand, Pull
from ...course.scenes import Press
from ...session.commands.commands import Edit, SetKnobs
from ...session.state.view import Picture
from ..viser_private import viser_internals
from ..viser_private.hidden_input import hidden_input
from ..viser_private.write_once import write_content

STEPS = 20  # of a slider from the middle to its end
LONGEST_WORD = 80  # letters of what a page says of a slider


class PullSliders:
    """One slider for each place where the plant can be pulled; none where it cannot, or where a scene asks for something else."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, post: Callable[[Edit], object]) -> None:
        self._post, self._lang = post, picture.state.language
        self._knobs = {knob.name: knob for knob in picture.lesson.knobs if isinstance(knob, Pull)}
        self._grip, self._holds = time.monotonic_ns(), False
        if not self._knobs:
            return
        self._hand = viser_internals.node_id(hidden_input(client.gui, self._heard))
        self._sliders = client.gui.add_html("")
        viser_internals.run_script(client, "slide", values={}, heard=0)
        self.show(picture)

    def show(self, picture: Picture) -> None:
        """The sliders of the grips that the body on the stage has."""
        if not self._knobs:
            return
        scene, stage = picture.scene, picture.outcome.stage
        asked = scene is None or (isinstance(scene.do, Press) and scene.do.button == "pull")
        held = [] if stage is None or not asked else [grip.knob for grip, _ in stage.held]
        write_content(self._sliders, "".join(self._slider(self._knobs[name]) for name in held if name in self._knobs))

    def _slider(self, knob: Pull) -> str:
        label = html.escape(f"{knob.label(self._lang)} [{knob.unit}]")
        return (f'<label class="ol-pull"><span>{label}</span><input type="range" min="{-STEPS}" max="{STEPS}" value="0" '
                f'data-slider="{knob.name}" data-from="0" data-springs data-most="{knob.most:g}" '
                f'data-unit="{html.escape(knob.unit, quote=True)}" data-to="{self._hand}"></label>')

    def _heard(self, said: str) -> None:
        """A knob, the share of the largest force, and whether the hand lets go; what is nonsense is passed over."""
        name, share, released = [*said[:LONGEST_WORD].split(":"), "", ""][:3]
        knob = self._knobs.get(name)
        try:
            force = float(share) * knob.most if knob is not None else math.nan
        except ValueError:
            return
        if not math.isfinite(force):
            return
        if not self._holds:
            self._grip += 1
        self._holds = released != "1"
        self._post(SetKnobs({name: ByHand(force, released == "1")}, self._grip))
