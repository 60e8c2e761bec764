"""Write what a presenter sees of the class: how many follow, the vote, and its histograms."""

from __future__ import annotations

import html

from ...classroom.room import RoomView
from ...course.scenes import Choose, Move
from ...session.state.view import Picture
from ...text import Text
from ..words import phrases
from ..words.link_code import qr_code
from .histogram import bars_html, question_words


def room_html(picture: Picture, hand: str) -> str:
    """The counts of the room and the vote; nothing in a tab that presents to nobody."""
    room = picture.state.room
    if room is None:
        return ""
    return f'<section class="ol-room">{_counts(picture, room, hand)}{_vote(picture, hand)}{_typed(picture, hand)}</section>'


def audience_html(picture: Picture) -> str:
    """The audience's address and its code, to be shown in the hall; nothing where the address is not known."""
    room, lang = picture.state.room, picture.state.language
    if room is None or not room.audience:
        return ""
    return (f'<details class="ol-ask"><summary>{html.escape(phrases.AUDIENCE_LINK(lang))}</summary>'
            f"<p>{html.escape(room.audience)}</p>{qr_code(room.audience)}</details>")


def ask_html(hand: str, language: str) -> str:
    """The field for a question that is typed on the spot; it never changes, so that nothing takes away what is being typed."""
    hint = html.escape(phrases.TYPE_QUESTION(language), quote=True)
    return (f'<details class="ol-ask"><summary>{html.escape(phrases.ASK_CLASS(language))}</summary>'
            f'<textarea rows="4" maxlength="1500" aria-label="{hint}" placeholder="{hint}"></textarea>'
            f'<button type="button" class="ol-do" data-asks="{hand}" data-kind="ask">{html.escape(phrases.OPEN_VOTE(language))}</button> '
            f'<button type="button" class="ol-do" data-asks="{hand}" data-kind="pole">{html.escape(phrases.ASK_POLE(language))}</button>'
            "</details>")


def _typed(picture: Picture, hand: str) -> str:
    """The typed question with its counts, and the button that closes or repeats its vote."""
    if not picture.typed:
        return ""
    vote, lang = picture.typed[-1], picture.state.language
    assert vote.asked is not None
    options = "".join(f"<li>{html.escape(option)}</li>" for option in vote.asked.options)
    button = _button(hand, "vote:close", phrases.CLOSE_VOTE, lang) if vote.open else _button(hand, "vote:typed", phrases.VOTE_AGAIN, lang)
    return (f'<h3 class="ol-asked">{html.escape(question_words(vote.asked, lang))}</h3><ol class="ol-letters">{options}</ol>'
            f"{button}{bars_html(picture.typed, lang)}")


def way_back(language: str) -> str:
    """The link from a copy of one's own to the lecture."""
    return f'<p class="ol-back"><a class="ol-do" href="./">{html.escape(phrases.BACK_TO_LECTURE(language))}</a></p>'


def _button(hand: str, value: str, words: Text, language: str) -> str:
    return f'<button type="button" class="ol-do" data-to="{hand}" data-value="{value}">{html.escape(words(language))}</button>'


def _counts(picture: Picture, room: RoomView, hand: str) -> str:
    lang = picture.state.language
    said = [phrases.HERE.format(here=room.here, following=room.following)]
    said += [phrases.AT_PLACE.format(place=_place(picture, place), count=count) for place, count in room.places]
    said += [phrases.TRIED.format(place=_place(picture, place), count=count) for place, count in room.unsolved]
    lines = html.escape(" · ".join(words(lang) for words in said))
    slower = "" if not room.slower else (f'<p class="ol-note ol-slower">{html.escape(phrases.ASK_SLOWER.format(count=room.slower)(lang))} '
                                         f"{_button(hand, 'hands', phrases.LOWER_HANDS, lang)}</p>")
    return f'<p class="ol-note ol-here">{lines}</p>{slower}'


def _place(picture: Picture, place: str) -> str:
    """A lesson and its scene or task by their titles."""
    lesson, _, part = place.partition("/")
    words = next((each.words[picture.state.language] for each in picture.catalogue if each.id == lesson), None)
    if words is None:
        return place
    titles = {name: scene.title for name, scene in words.scenes.items()} | {name: task.title for name, task in words.tasks.items()}
    return words.title + (f", {titles[part]}" if part in titles else "")


def _vote(picture: Picture, hand: str) -> str:
    """The button that opens or closes the vote, and the counts while they rise; nothing says which option is right."""
    scene, votes, lang = picture.scene, picture.votes, picture.state.language
    if scene is not None and isinstance(scene.do, Move) and not picture.typed and (
            {board.knob for board in picture.boards} & set(scene.do.knobs)):
        return _button(hand, "pole:", phrases.ASK_POLE, lang)
    if scene is None or not isinstance(scene.do, Choose):
        return ""
    word = phrases.CLOSE_VOTE if picture.voting else phrases.VOTE_AGAIN if votes else phrases.OPEN_VOTE
    return _button(hand, "vote:close" if picture.voting else "vote:open", word, lang) + (bars_html(votes, lang) if votes else "")
