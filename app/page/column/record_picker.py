"""Show the record in a file before a lesson uses it: what was read, and what is asked."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser

from ...course.figures.curves import thin_samples
from ...course.figures.records import Curve, PlaneFigure
from ...engine.identification import Record
from ...session.commands.commands import Edit
from ...session.commands.records import DropRecord, SetColumnRole, StopFit, TellOfRecord, UploadRecord, UseRecord
from ...session.state.record_file import DECIMALS, MAX_RECORD_BYTES, ROLES, TIME_UNITS, RecordFile
from ...session.state.view import Picture
from ...text import error_words, same
from ..charts.svg import draw
from ..viser_private.widget_values import ReadBack
from ..words import phrases
from ..words.prose import with_minus

Post = Callable[[Edit], int]
MIME = ".csv,.txt,.tsv,.dat,.mat"
POINTS, LANE = 300, 0.8  # points of a curve; height of a signal in its lane
HEIGHT, LANE_HEIGHT = 60.0, 45.0  # of the plot, and more for each signal


@dataclass(frozen=True, eq=False)
class _Row:
    """A widget of the preview with the value that a file gives it."""

    handle: Any  # viser's widgets share no class that tells their value
    back: ReadBack
    value: Callable[[RecordFile], object]


class RecordPicker:
    """A folder with a button that takes a file; once there is one, its preview."""

    def __init__(self, gui: viser.GuiApi, picture: Picture, post: Post) -> None:
        self._gui, self._post, self._lang = gui, post, picture.state.language
        self._folder = gui.add_folder(phrases.RECORD_FILE(self._lang))
        self._rows: list[_Row] = []
        self._others: list[Any] = []  # widgets without a value, likewise
        self._columns: tuple[str, ...] = ()
        self._shown: RecordFile | None = None
        with self._folder:
            upload = gui.add_upload_button(phrases.UPLOAD_RECORD(self._lang), hint=phrases.UPLOAD_RECORD_HINT(self._lang), color="gray",
                                           mime_type=MIME)

        @upload.on_upload
        async def _(event: viser.GuiEvent) -> None:
            file = event.target.value
            post(UploadRecord(file.name, file.content[:MAX_RECORD_BYTES + 1]))

    def show(self, picture: Picture) -> None:
        """The file that is looked at now, if there is one."""
        file = picture.state.record_file
        columns = () if file is None else (file.name, *(column.words for column in file.preview.columns))
        if columns != self._columns:
            self._columns, self._shown = columns, None
            self._clear()
            if file is not None:
                self._build(file)
        if file is None:
            return
        for row in self._rows:
            row.back.show(row.value(file), picture)
        if self._shown is None or file.preview is not self._shown.preview:
            self._said.content = preview_html(file, self._lang)
        self._shown = file
        self._show_fit(file)

    def _show_fit(self, file: RecordFile) -> None:
        """How far the fit is and how long it goes on, while there is one."""
        fitting = file.fitting
        if fitting is not None:
            left = fitting.seconds_left
            words = phrases.FITTING if left is None else phrases.FITTING_FOR.format(seconds=f"{max(left, 1.0):.0f}")
            self._lasts.content = f'<p class="ol-note" role="status">{words(self._lang)}</p>'
            self._bar.value = 100.0 * fitting.share
        for handle in (self._lasts, self._bar, self._stop):
            if handle.visible != (fitting is not None):
                handle.visible = fitting is not None
        self._use.disabled = file.preview.record is None or fitting is not None

    def _clear(self) -> None:
        for row in self._rows:
            row.handle.remove()
        for handle in self._others:
            handle.remove()
        self._rows, self._others = [], []

    def _build(self, file: RecordFile) -> None:
        gui, lang = self._gui, self._lang
        roles = dict(zip(ROLES, (word(lang) for word in (phrases.ROLE_TIME, phrases.ROLE_INPUT, phrases.ROLE_OUTPUT, phrases.ROLE_UNUSED)),
                         strict=True))
        found = phrases.AS_FOUND(lang)
        with self._folder:
            self._said = gui.add_html("")
            for k, column in enumerate(file.preview.columns):
                unit = f" [{column.unit}]" if column.unit and column.unit not in column.words else ""
                self._choice(phrases.COLUMN.format(name=column.words + unit)(lang), roles, lambda its, k=k: its.preview.columns[k].role,
                             lambda role, k=k: SetColumnRole(k, role), file, phrases.ROLE_HINT(lang))
            self._use = gui.add_button(phrases.USE_RECORD(lang))
            self._lasts, self._bar = gui.add_html("", visible=False), gui.add_progress_bar(0.0, visible=False)
            self._stop = gui.add_button(phrases.CANCEL_JOB(lang), color="gray", visible=False)
            drop = gui.add_button(phrases.DROP_RECORD(lang), color="gray")
            self._others = [self._said, self._use, self._lasts, self._bar, self._stop, drop]
            self._choice(phrases.TIME_UNIT(lang), {unit: unit or found for unit in TIME_UNITS}, lambda its: its.told.unit,
                         lambda unit: TellOfRecord("unit", unit), file)
            self._choice(phrases.DECIMAL_SIGN(lang), {sign: sign or found for sign in DECIMALS}, lambda its: its.told.decimal,
                         lambda sign: TellOfRecord("decimal", sign), file)
            self._keep(gui.add_number(phrases.STEP_OF_ROWS(lang), 0.0, min=0.0, hint=phrases.STEP_OF_ROWS_HINT(lang)), "step",
                       lambda its: its.told.step)
            self._keep(gui.add_text(phrases.MISSING_MARKS(lang), "", hint=phrases.MISSING_MARKS_HINT(lang)), "missing",
                       lambda its: its.told.missing)
            self._keep(gui.add_checkbox(phrases.HOLD_INPUTS(lang), False), "hold", lambda its: its.told.hold)

        @self._use.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._post(UseRecord())

        @self._stop.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._post(StopFit())

        @drop.on_click
        async def _(_: viser.GuiEvent) -> None:
            self._post(DropRecord())

    def _choice(self, label: str, words: dict[str, str], value: Callable[[RecordFile], str], edit: Callable[[str], Edit], file: RecordFile,
                hint: str | None = None) -> None:
        keys = {said: key for key, said in words.items()}
        handle = self._gui.add_dropdown(label, tuple(words.values()), initial_value=words[value(file)], hint=hint)
        self._rows.append(_Row(handle, ReadBack(handle, lambda said: self._post(edit(keys.get(said, "")))), lambda its: words[value(its)]))

    def _keep(self, handle: Any, name: str, value: Callable[[RecordFile], object]) -> None:
        self._rows.append(_Row(handle, ReadBack(handle, lambda given: self._post(TellOfRecord(name, given))), value))


def preview_html(file: RecordFile, language: str) -> str:
    """What was read of a file: its size, what was done to it or is asked, and its signals."""
    preview = file.preview
    parts = [f'<p class="ol-note"><b>{html.escape(file.name)}</b></p>']
    if preview.problem is not None:
        parts.append(f'<p class="ol-note" role="alert">{html.escape(error_words(preview.problem)(language))}</p>')
    if preview.record is not None:
        said = (preview.record.size, *preview.record.notes)
        parts += [f'<p class="ol-note">{with_minus(html.escape(error_words(note)(language)))}</p>' for note in said]
        parts.append(f'<div class="ol-compared">{_drawn(preview.record, language)}</div>')
        parts.append(f'<p class="ol-caption">{phrases.RECORD_LANES(language)}</p>')
    return "".join(parts)


def _drawn(record: Record, language: str) -> str:
    """The signals above one another, inputs at the top."""
    names = (*record.input_names, *record.output_names)
    t, *signals = thin_samples(record.t, *record.u.T, *record.y.T, points=POINTS)
    curves = []
    for k, (name, signal) in enumerate(zip(names, signals, strict=True)):
        low, high = float(np.nanmin(signal, initial=np.inf)), float(np.nanmax(signal, initial=-np.inf))
        place = 0.5 * np.ones_like(signal) if not high > low else (signal - low) / (high - low)
        role = "force" if k < len(record.input_names) else "plant"
        unit = record.unit(name)
        label, lane = same(f"{name} [{unit}]" if unit else name), len(names) - 1 - k + LANE * place
        curves += [Curve(label, lane[piece], role, x=t[piece]) for piece in _pieces(lane)]
    figure = PlaneFigure("preview", phrases.RECORD_READ, tuple(curves), (), "t [s]", "", (float(t[0]), float(t[-1])),
                         (-0.1, float(len(names))), caption=phrases.RECORD_LANES)
    return draw(figure, language, high=HEIGHT + LANE_HEIGHT * len(names))


def _pieces(signal: np.ndarray) -> list[slice]:
    """The stretches of a signal between its missing values."""
    seen = np.concatenate([[False], np.isfinite(signal), [False]])
    edges = np.flatnonzero(seen[1:] != seen[:-1])
    return [slice(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]
