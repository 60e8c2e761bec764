"""Send the poses of a run ahead of time, so that the page plays it by itself."""

from __future__ import annotations

import viser

from ..stage.stage import StageView
from ..viser_private import viser_internals
from ..viser_private.stage_frames import Frame, changed_values, pack_frame
from .transport import PlaybackControls

FIRST_LEAD_S, MAX_LEAD_S = 0.8, 6.4  # s of playing that the first message covers, each further one twice as much, and the most
REFILL_LEAD_S = 0.4  # s that are still to be played when the next one is made
MAX_NEW_POSES = 40  # poses of one message that have not been computed before
MAX_PACKED_STEPS = 1500  # steps from one pose to the next that are kept packed


class Player:
    """The frames that one page has been given, and how far they reach. A page that has not said that it plays gets none."""

    def __init__(self, client: viser.ClientHandle, stage: StageView, transport: PlaybackControls) -> None:
        self._client, self._stage, self._transport = client, stage, transport
        self._plays = False
        self._until: float | None = None  # time of the run up to which the page has frames, None while it plays nothing
        self._given = (0.0, 0.0)  # the last time that was asked for, and the rate
        self._ahead = FIRST_LEAD_S
        self._built: object = None
        self._names: dict[str, int] = {}
        self._packed: dict[tuple[object, object], str] = {}
        widget = client.gui.add_number("", 0.0, visible=False)

        @widget.on_update
        async def _(event: viser.GuiEvent) -> None:
            self._plays = event.client_id is not None
        viser_internals.run_script(client, "play", widget=viser_internals.node_id(widget))

    @property
    def plays(self) -> bool:
        """Whether the page moves between poses by itself."""
        return self._plays

    def stop(self) -> None:
        """Take back what the page has not shown yet; the next pose is sent whole."""
        if self._until is None:
            return
        self._until = None
        self._stage.forget()
        self._transport.forget()
        viser_internals.run_script(self._client, "play", stop=True)

    def go_on(self, t: float, end: float, rate: float, every: float) -> float:
        """Let the page play from t on at `rate` to `end`, a pose `every` so many seconds; the seconds that it can go by itself."""
        begins = self._until is None or t < self._given[0] or rate != self._given[1] or t > self._until
        until = t if begins or self._until is None else self._until
        self._given = t, rate
        if until - t <= REFILL_LEAD_S * rate and (until < end or begins):
            self._ahead = FIRST_LEAD_S if begins else min(2 * self._ahead, MAX_LEAD_S)
            count = max(1, round(self._ahead / every))
            times = [min(until + every * rate * k, end) for k in range(0 if begins else 1, count + 1)]
            times = times[:next((k for k, time in enumerate(times) if time >= end), len(times)) + 1]
            self._until = until = self._send(times, begins, every)
        return max(0.0, until - t) / rate

    def _send(self, times: list[float], begins: bool, every: float) -> float:
        """Send the poses of these times, but not many that are new: nobody's hand waits for a long run. The time of the last."""
        if self._built is not self._stage.built:
            self._built, self._names, self._packed = self._stage.built, {}, {}
        if len(self._packed) > MAX_PACKED_STEPS:
            self._packed = {}
        frames, fresh = list[str](), 0
        before, stands = (None, Frame()) if begins else (self._stage.place_at(self._until or 0.0), None)
        for time in times:
            place = self._stage.place_at(time)
            known = self._packed.get((before, place))
            if known is None and fresh == MAX_NEW_POSES:
                break
            if known is None:
                now = self._stage.frame_at(place)
                known = pack_frame(changed_values(self._stage.frame_at(before) if stands is None else stands, now), self._names)
                self._packed[before, place], stands, fresh = known, now, fresh + 1
            else:
                stands = None
            frames.append(known)
            before = place
        times = times[:len(frames)]
        viser_internals.run_script(
            self._client,
            "play",
            begins=begins,
            every=1e3 * every,
            owner=str(self._client.client_id),
            names=list(self._names),
            times=[round(time, 9) for time in times],
            told=self._transport.told,
            moves=f"[{','.join(frames)}]",
        )
        self._client.flush()
        return times[-1]
