"""Say which function carries out which command: the only place that knows both.

A function takes the tab's presenter and then the fields of its command, under their names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import msgspec

from ..commands import commands, exams, files, guide, records, room
from ..commands.commands import Command
from . import design, downloads, kept_designs, lectures, lesson_reload, page, playback, sharing, tasks
from . import exams as exam
from . import guide as path
from . import records as record
from . import room as hall
from .presenter import Presenter
from .reload import restore_memory

HANDLERS: Mapping[type[Command], Callable[..., object]] = MappingProxyType({
    commands.Play: playback.play,
    commands.Rewind: lambda show: playback.seek(show, 0.0),
    commands.Seek: playback.seek,
    commands.ChangeSpeed: playback.change_speed,
    commands.Kick: playback.kick,
    commands.PageSeen: playback.watch,
    commands.Undo: design.undo,
    commands.Redo: design.redo,
    commands.Reset: design.reset,
    commands.DrawByHand: design.draw_by_hand,
    commands.PickPoint: design.pick_point,
    commands.UploadPlant: design.upload_plant,
    commands.ChoosePlant: design.choose_plant,
    records.UploadRecord: record.upload_record,
    records.SetColumnRole: record.set_column_role,
    records.TellOfRecord: record.tell_of_record,
    records.UseRecord: record.use_record,
    records.StopFit: record.stop_fit,
    records.FitGoesOn: record.follow_fit,
    records.FitEnded: record.end_fit,
    records.DropRecord: record.drop_record,
    commands.Refuse: design.refuse,
    commands.Predict: tasks.predict,
    commands.PredictAgain: tasks.predict_again,
    commands.ShowAgain: tasks.show_again,
    commands.Reveal: tasks.reveal,
    commands.CheckTask: tasks.check_task,
    commands.CheckNextTask: tasks.check_next_task,
    commands.ShowHint: tasks.show_hint,
    commands.ShowSolution: tasks.show_solution,
    commands.RunJob: tasks.start_or_cancel_job,
    exams.AnswerExam: exam.answer_exam,
    exams.AnotherVariant: exam.turn_variant,
    exams.SetKey: exam.set_key,
    exams.SetWord: exam.set_word,
    exams.WithholdResults: exam.withhold_results,
    exams.HandIn: exam.hand_in,
    exams.SaveHandIn: exam.save_hand_in,
    exams.HandInReported: lambda show, report: show.view.say(report.words, report.bad),
    commands.OpenState: sharing.open_state,
    commands.PlaceOpened: sharing.note_place,
    commands.ToggleDownloads: sharing.toggle_downloads,
    commands.SaveState: sharing.save_state,
    files.DownloadFile: downloads.download_file,
    files.FileReady: downloads.take_file,
    files.PinDesign: kept_designs.pin,
    files.Unpin: kept_designs.unpin,
    files.OpenPin: kept_designs.open_pin,
    files.ToggleGhost: kept_designs.toggle_ghost,
    files.GoToStep: kept_designs.go_to_step,
    files.SaveDesign: kept_designs.save_design,
    files.OpenSavedDesign: kept_designs.open_saved_design,
    files.DeleteSavedDesign: kept_designs.delete_saved_design,
    files.ClearBrowser: kept_designs.clear_browser,
    commands.OpenLesson: page.open_lesson,
    commands.TurnPage: page.turn_page,
    files.LessonsChanged: lesson_reload.take_changed_lessons,
    files.UploadLessons: lesson_reload.upload_lessons,
    files.LessonsRead: lesson_reload.take_read_lessons,
    files.LinesCame: page.show_lines,
    commands.SetLanguage: page.set_language,
    commands.ToggleLecture: lambda show: show.rebuild(replace(show.state, lecture=not show.state.lecture)),
    commands.ToggleTheme: lambda show: show.rebuild(replace(show.state, dark=not show.state.is_dark)),
    commands.WindowChanged: page.see_window,
    commands.ToggleNames: page.toggle_names,
    commands.ToggleLandscape: lambda show: show.change(replace(show.state, landscape=not show.state.landscape)),
    commands.LookFrom: lambda show, place: show.view.camera(place),
    commands.ToggleHelp: lambda show: show.view.open_help(),
    guide.ToggleGlossary: lambda show: show.view.open_glossary(),
    commands.ToggleCourse: lambda show: show.view.open_course(show.lesson_states.progress(show.lesson.id, show.state)),
    commands.Answer: page.answer,
    commands.RunOnTabThread: lambda show, do: do(),
    commands.MemoryRecalled: restore_memory,
    guide.SetMode: path.set_mode,
    guide.GoToScene: lectures.go_to_scene,
    guide.TurnScene: lectures.turn_scene,
    guide.TurnedTo: lectures.turn_to,
    guide.ChooseOption: path.choose_option,
    guide.AnswerByHand: path.answer_by_hand,
    guide.RestartScene: path.restart_scene,
    guide.ShowKeptRun: path.show_kept_run,
    guide.OpenLecture: lectures.open_lecture,
    guide.EndLecture: lectures.end_lecture,
    guide.RecordStop: lectures.record_stop,
    guide.SaveLecture: lectures.save_lecture,
    room.OpenVote: hall.open_vote,
    room.AskTyped: hall.ask_typed,
    room.AskPole: hall.ask_pole,
    room.AskSketch: hall.ask_sketch,
    room.AskTypedAgain: hall.ask_typed_again,
    room.CloseVote: hall.close_vote,
    room.ShowCounts: hall.show_counts,
    room.HideCounts: hall.hide_counts,
    room.Discuss: hall.discuss,
    room.Reveal: hall.reveal,
    room.PerformAnswer: path.perform_answer,
    room.LowerHands: hall.lower_hands,
    room.PauseAll: hall.pause_all,
    room.EndPause: hall.end_pause,
    room.Freeze: hall.freeze,
    room.RoomChanged: hall.show_room,
    room.LeadShown: sharing.follow_lead,
    room.RunSeeds: lambda show: show.run_seeds(),
})


def run_command(show: Presenter, command: Command) -> None:
    """Do what a command asks. Raises KnobError, EngineError and what a lesson raises."""
    HANDLERS[type(command)](show, *msgspec.structs.astuple(command))
