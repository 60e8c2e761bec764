"""Show which plant a lesson uses: its own, an example, or one from a file."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import viser

from ...plants.examples import EXAMPLES, example
from ...plants.own_plant import plant_of
from ...plants.signal_names import title_of
from ...session.commands.commands import ChoosePlant, Edit, UploadPlant
from ...session.handlers.design import YOURS
from ...session.state.view import Picture
from ...text import Text
from ..viser_private.widget_values import ReadBack
from ..words import phrases

MOST_BYTES = 1_000_000
LESSON_PLANT, FIRST_EXAMPLE = "", next(iter(EXAMPLES))  # what a lesson shows by itself; one about any plant shows the first example


@lru_cache(maxsize=64)
def plant_name(plant: str) -> Text:
    """What a plant in its canonical text is called."""
    return title_of(plant_of(plant))


class PlantRow:
    """A dropdown of plants and a button that takes a file."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Callable[[Edit], int]) -> None:
        self._language = picture.state.language
        self._words = self._choices(picture)
        now = self._words[self._present(picture)]
        self._choice = gui.add_dropdown(phrases.PLANT(self._language), tuple(self._words.values()), initial_value=now)
        self._upload = gui.add_upload_button(phrases.UPLOAD(self._language), hint=phrases.UPLOAD_HINT(self._language),
                                             color="gray", mime_type=".json,.mat")
        self._back = ReadBack(self._choice, lambda words: post(ChoosePlant(self._key(words))))

        @self._upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            post(UploadPlant(file.name, file.content[:MOST_BYTES + 1]))

    def _choices(self, picture: Picture) -> dict[str, str]:
        """The key of each plant and what the dropdown calls it."""
        found = {} if picture.lesson.universal else {LESSON_PLANT: phrases.OWN_PLANT(self._language)}
        found |= {key: phrases.EXAMPLE.format(name=it.label)(self._language) for key, it in EXAMPLES.items()}
        brought = picture.design.plant if self._present(picture) == YOURS else picture.state.plant
        if brought:
            found[YOURS] = phrases.YOURS.format(name=plant_name(brought))(self._language)
        return found

    def _key(self, words: str) -> str:
        return next((key for key, known in self._words.items() if known == words), LESSON_PLANT)

    def _present(self, picture: Picture) -> str:
        plant = picture.design.plant
        if not plant:
            return FIRST_EXAMPLE if picture.lesson.universal else LESSON_PLANT
        return next((key for key in EXAMPLES if example(key) == plant), YOURS)

    def show(self, picture: Picture) -> None:
        """The plant that is shown now."""
        words = self._choices(picture)
        if words != self._words:
            self._words = words
            self._choice.options = tuple(words.values())
        self._back.show(words[self._present(picture)], picture)
