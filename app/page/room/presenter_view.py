"""Make the pages of those who act in a room: the presenter, and who works on a copy."""

from __future__ import annotations

from typing import Any

import viser

from ...session.handlers.room import PAUSED
from ...session.state.view import Picture
from ..screen.screen import Screen
from ..viser_private import page_scripts
from ..votes.room_card import way_back
from .broadcast import Broadcast
from .follower import ABOVE_ALL

LOOK_TOLERANCE = 0.02  # stage units that a camera may move unnoticed


class PresenterScreen(Screen):
    """A presenter's page; the room sees each picture, the run and the camera. One that no longer `leads` shows to nobody."""

    def __init__(self, client: viser.ClientHandle, broadcast: Broadcast) -> None:
        super().__init__(client)
        self._broadcast, self.leads = broadcast, True
        self._seen_from: Any = ()
        self._plays = False

        @client.camera.on_update
        async def _(_: viser.CameraHandle) -> None:
            self._tell_look()

    def build(self, picture: Picture) -> None:
        """Lay everything out anew, here and for the room."""
        super().build(picture)
        if self.leads:
            self._broadcast.build(picture)

    def show(self, picture: Picture) -> None:
        """Show a picture, here and to the room."""
        super().show(picture)
        if self.leads:
            self._broadcast.show(picture)

    def pose(self, t: float) -> None:
        """Stage and cursors at time t, here and for the room."""
        super().pose(t)
        if self.leads and not self._plays:
            self._broadcast.move(lambda screen: screen.pose(t))

    def play(self, t: float, end: float, rate: float, every: float) -> float:
        """Show the run from t on, here and to the room, whose pages always play by themselves."""
        if self.leads:
            self._broadcast.move(lambda screen: screen.play(t, end, rate, every))
        self._plays = True  # a pose of this page's own is none for the room
        try:
            return super().play(t, end, rate, every)
        finally:
            self._plays = False

    def camera(self, preset: str) -> None:
        """Look from a named place, here and for the room."""
        super().camera(preset)
        self._tell_look()

    def look(self, camera: tuple[float, ...] | None) -> None:
        """Look from a position at a target, here and for the room."""
        super().look(camera)
        self._tell_look()

    def lead_again(self) -> None:
        """Show the room what stands here: the tab that led has left."""
        if self._picture is not None:
            self._broadcast.build(self._picture)

    def _tell_look(self) -> None:
        eye = self.eye()
        if self.leads and not _alike(eye, self._seen_from):
            self._seen_from = eye
            self._broadcast.look(lambda screen: screen.look(eye))


class OwnScreen(Screen):
    """The page of somebody who has left the lecture for a copy of their own, with the link that leads back."""

    _frozen: bool | None = None  # None: it is not known how the page of the browser stands

    def show(self, picture: Picture) -> None:
        """Show a picture; while the presenter pauses the class, under a sentence."""
        super().show(picture)
        frozen, language = picture.state.frozen, picture.state.language
        if frozen is not self._frozen:
            self._frozen = frozen
            page_scripts.freeze(self._client, PAUSED(language) if frozen else "")
            self._client.flush()

    def build(self, picture: Picture) -> None:
        """Lay everything out anew, the link first."""
        super().build(picture)
        self._client.gui.add_html(way_back(picture.state.language), order=ABOVE_ALL)
        self._client.flush()


def _alike(one: Any, other: Any) -> bool:
    if not one or not other:
        return one == other
    return all(abs(a - b) <= LOOK_TOLERANCE for a, b in zip(one, other, strict=True))
