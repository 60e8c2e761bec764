"""What a page learns once, when its first lesson is laid out: how it draws, what its keys and its pointer mean."""

from __future__ import annotations

import viser

from . import quirks
from .grips import FAINT, GRIPS


def teach(client: viser.ClientHandle) -> None:
    """Run every script that a page keeps until it is closed."""
    quirks.frugal_frames(client)
    quirks.folders_by_key(client)
    quirks.one_meaning_per_key(client)
    quirks.sentences_to_press(client)
    quirks.values_under_the_pointer(client)
    quirks.one_part_at_a_time(client)
    quirks.stay_above_the_floor(client)
    quirks.pulse_once(client, GRIPS, FAINT)
