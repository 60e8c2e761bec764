"""Show a presenter the class: how many follow, the vote with its histograms, a field for a question."""

from __future__ import annotations

import html
from functools import partial
from types import MappingProxyType

import viser

from ...classroom.room import RoomView
from ...classroom.votes import DISCUSS_S, Vote
from ...course.scenes import Choose, Move
from ...session.commands.commands import Command
from ...session.commands.room import (
    AskPole,
    AskSketch,
    AskTyped,
    AskTypedAgain,
    CloseVote,
    Discuss,
    EndPause,
    HideCounts,
    LowerHands,
    OpenVote,
    PauseAll,
    Reveal,
    ShowCounts,
)
from ...session.state.view import Picture
from ...text import Text
from ..viser_private import viser_internals
from ..viser_private.write_once import write_content
from ..words import phrases
from ..words.link_code import qr_code
from .class_drawings import drawings_html
from .histogram import bars_html, discussion_html, question_words, results_html

VOTES = MappingProxyType({"close": CloseVote, "typed": AskTypedAgain, "sketch": AskSketch})
STAGES = MappingProxyType({"show": ShowCounts, "hide": HideCounts, "discuss": Discuss, "reveal": Reveal})


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
    button = _stage(vote, hand, "vote:typed", lang)
    return (f'<h3 class="ol-asked">{html.escape(question_words(vote.asked, lang))}</h3><ol class="ol-letters">{options}</ol>'
            f"{button}{bars_html(picture.typed, lang)}{discussion_html(picture.typed, lang)}")


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
    failing = f'<p class="ol-note ol-failing">{html.escape(phrases.STORE_FAILS(lang))}</p>' if room.failing else ""
    return f'{failing}<p class="ol-note ol-here">{lines}</p>{slower}{_pause(room, hand, lang)}'


def _pause(room: RoomView, hand: str, language: str) -> str:
    """The button that pauses the pages of the class; while they are paused, that they are, and the button that ends it."""
    if not room.paused:
        return f"<p>{_button(hand, 'pause:on', phrases.PAUSE_ALL, language)}</p>"
    told = html.escape(phrases.ALL_PAUSED(language))
    return f'<p class="ol-note ol-failing">{told} {_button(hand, "pause:off", phrases.END_PAUSE, language)}</p>'


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
    if not votes:
        steps = [("vote:open", phrases.OPEN_VOTE)]
        if picture.question is not None and picture.question.columns and not picture.typed:
            steps.append(("vote:sketch", phrases.ASK_SKETCH))
        return " ".join(_button(hand, value, words, lang) for value, words in steps)
    return _stage(votes[-1], hand, "vote:open", lang) + bars_html(votes, lang) + discussion_html(votes, lang)


def _stage(vote: Vote, hand: str, again: str, language: str) -> str:
    """The buttons of what may come next: close the vote, show its counts, discuss, ask again, tell the answer."""
    if vote.open:
        return _button(hand, "vote:close", phrases.CLOSE_VOTE, language)
    shows = ("hide", phrases.HIDE_COUNTS) if vote.counts_out else ("show", phrases.SHOW_COUNTS)
    steps = [(f"vote:{shows[0]}:{vote.number}", shows[1])]
    if not vote.revealed:
        steps.append((f"vote:discuss:{vote.number}", phrases.DISCUSS.format(minutes=round(DISCUSS_S / 60))))
    steps.append((again, phrases.VOTE_AGAIN))
    if (vote.asked is None or vote.kind == "sketch") and not vote.revealed:
        steps.append((f"vote:reveal:{vote.number}", phrases.REVEAL_ANSWER))
    return " ".join(_button(hand, value, words, language) for value, words in steps)


def hall_html(picture: Picture) -> str:
    """What the hall sees in large print over a stage at rest: results of the latest vote that are shown, or the time to discuss."""
    if picture.state.performance is not None or picture.state.playing:
        return ""
    votes = max((picture.votes, picture.typed), key=lambda found: found[-1].number if found else 0)
    said = results_html(votes, picture.state.language, partial(drawings_html, picture)) if picture.state.mode == "present" else ""
    asked = votes[-1].asked if votes and said else None
    head = "" if asked is None else f'<h3 class="ol-asked">{html.escape(question_words(asked, picture.state.language))}</h3>'
    return head + said


def room_command(kind: str, value: str) -> Command | None:
    """What a button of the panel asks for; None where the words are of another part of the page."""
    match kind:
        case "vote":
            step, _, number = value.partition(":")
            return STAGES[step](number) if step in STAGES else VOTES.get(value, OpenVote)()
        case "ask":
            return AskTyped(value)
        case "pole":
            return AskPole(value)
        case "hands":
            return LowerHands()
        case "pause":
            return PauseAll() if value == "on" else EndPause()
    return None


class RoomPanel:
    """What a presenter sees of the class. Nothing where the tab presents to nobody."""

    def __init__(self, client: viser.ClientHandle, picture: Picture, hand: str) -> None:
        """`hand` is the widget for which the buttons answer."""
        self._hand, self._client = hand, client
        self._hall: str | None = None  # what this page shows over the stage, None where that is not known
        self._told: str | None = None  # what the speaker's window shows of the class
        self._room = client.gui.add_html("") if picture.state.room is not None else None
        self._ask = ask_html(hand, picture.state.language) + audience_html(picture)
        if self._room is not None:
            client.gui.add_html(self._ask)
            viser_internals.run_script(client, "ask")

    def show(self, picture: Picture) -> None:
        """The counts as they are now."""
        if self._room is not None:
            room = room_html(picture, self._hand)
            write_content(self._room, room)
            if room != self._told:
                self._told = room
                viser_internals.run_script(self._client, "presenter", room=room, ask=self._ask, hand=self._hand)
            hall = hall_html(picture)
            if hall != self._hall:
                self._hall = hall
                viser_internals.run_script(self._client, "hall", html=hall)
