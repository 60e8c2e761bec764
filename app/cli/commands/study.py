"""Run a lesson at many designs, seeds or plants on any executor: `study`."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..options import THREADS, CommandError, add_json, error_cause, whole_number
from ..terminal import Progress

if TYPE_CHECKING:
    from ...study.ledger import Ledger
    from ...study.plan import Row, Study

HELP = "a lesson at many designs, seeds or plants: Monte-Carlo, maps, sweeps"
FORMAT = """FILE is JSON; lesson alone is needed:

  {"lesson": "saturation", "set": {"u_max": 0.1}, "plant": "motor",
   "vary": {"start": {"from": -3, "to": 3, "count": 41}, "fed": ["commanded", "applied"],
            "A(3,4)": {"from": -2, "to": -0.5, "count": 5},
            "inertia": {"from": 0.5, "to": 2, "count": 7, "scale": "log", "over": ["A(2,1)", "A(2,2)"]}},
   "seeds": 20, "seed": 1, "collect": ["largest_asked", "check.home"], "final": false}

set and vary take knobs as `observer-lab list` names them; a value reads as JSON or as --set reads it. What varies is a list of
values, or a range, whose scale is the knob's own unless given. plant is a file beside this one, the name of an example, or a
plant as such a file holds it; its entries, counted from 1, vary too, and so does any other name that multiplies the entries
times and divides the entries over. seeds is how many are drawn for each point, from seed; or a list or a range of them, the
same at every point. collect names metrics of `observer-lab run --json`, and check. with the id of a check; all of them unless
given. final does the lesson's long computation at every point.

FOLDER gets runs.csv with every run, study.json with all of it, a figure where at most two things vary, and runs.txt, what is
done: the same command goes on from there. The results are the same to the last bit, whoever computes them."""
ADDRESS = "local"
MOST_WORKERS = 256


def arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `study`."""
    from ...text.languages import languages

    parser.epilog, parser.formatter_class = FORMAT, argparse.RawDescriptionHelpFormatter
    parser.add_argument("file", metavar="FILE")
    parser.add_argument("--scheduler", metavar="ADDRESS", default=ADDRESS, help="a Dask scheduler, such as tcp://127.0.0.1:8786 "
                        "(default: processes of this machine)")
    parser.add_argument("--workers", type=whole_number(1, MOST_WORKERS, f"is no number of processes from 1 to {MOST_WORKERS}"), metavar="N",
                        help="processes of this machine (default: one for each core)")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="where to (default: the file's name, in this folder); what is done "
                        "already is found there")
    parser.add_argument("--lang", choices=languages(), default="en", help="language of the figure (default: en)")
    add_json(parser)


def execute(options: argparse.Namespace) -> int:
    """Read the study, run what is not done yet, write table, record and figure; 130 if it was interrupted."""
    if "numpy" not in sys.modules:  # sums of several threads are rounded in another order
        os.environ.update(dict.fromkeys(THREADS, "1"))
    from ...study.ledger import Ledger
    from ...study.plan import StudyError, digest, programs

    if options.workers is not None and options.scheduler != ADDRESS:
        raise CommandError("Give --workers or --scheduler, not both: a scheduler has workers of its own.")
    try:
        study = _study_in(options.file)
        folder = Path(options.output or f"{Path(options.file).stem}.study")
        mark = digest(study, programs())
        folder.mkdir(exist_ok=True)
        with Ledger(folder / "runs.txt", study, mark) as ledger:
            try:
                _run(study, ledger, options)
            except KeyboardInterrupt:
                print(f"\nobserver-lab: stopped with {len(ledger.rows)} of {study.size} runs done; the same command goes on from "
                      "there.", file=sys.stderr)
                return 128 + signal.SIGINT
            return _write(study, ledger, folder, mark, options)
    except StudyError as problem:
        raise CommandError(str(problem)) from problem
    except OSError as problem:
        raise CommandError(f"The folder of the study cannot be used ({error_cause(problem)}); what is in it is kept, and the same command "
                           "goes on from there.") from problem


def _study_in(name: str) -> Study:
    from ...plants.examples import EXAMPLES
    from ...study.study_parser import read_study
    from ..inputs import read_plant, read_text

    beside = Path(name).parent
    words = read_text(name, "study", "give the JSON of a study")
    return read_study(words, lambda plant: read_plant(plant if plant in EXAMPLES else str(beside / plant)))


def _run(study: Study, ledger: Ledger, options: argparse.Namespace) -> None:
    from ...study.executors import cores, in_process, on_dask, on_processes

    missing = [index for index in range(study.size) if index not in ledger.rows]
    if not missing:
        return
    workers = min(options.workers or cores(), len(missing))
    rows: Iterator[list[Row]] = (on_dask(study, missing, options.scheduler) if options.scheduler != ADDRESS else
                                 in_process(study, missing) if workers == 1 else on_processes(study, missing, workers))
    progress = Progress(study.size, len(ledger.rows))
    try:
        for chunk in rows:
            ledger.add(chunk)
            progress.tell(len(ledger.rows))
    finally:
        rows.close()  # type: ignore[attr-defined]
        progress.end()


# --- what comes of it --------------------------------------------------------------------------------------------------
def _write(study: Study, ledger: Ledger, folder: Path, mark: str, options: argparse.Namespace) -> int:
    from observer_lab.lessons import LESSONS

    from ...course.knobs import KnobError
    from ...session.state.saved_state import SavedState
    from ...session.state.token import write_token
    from ...study.figures import figure_as
    from ...study.plan import programs
    from ...study.points import design_of
    from ...study.results import result_record, save_table, summaries
    from ..outputs import save_bytes, write_whole_file
    from ..printing import print_json

    rows, language = ledger.rows, options.lang
    try:
        token = write_token(LESSONS[study.lesson], SavedState(design_of(study)[1], language))
    except KnobError:  # what is set fits none but changed plants
        token = ""
    found = summaries(study, rows)
    whole_record = result_record(study, rows, found, mark, token, programs())
    words = json.dumps(whole_record, ensure_ascii=False, allow_nan=False)
    write_whole_file(str(folder / "runs.csv"), lambda path: save_table(study, rows, path, mark, token))
    write_whole_file(str(folder / "study.json"), lambda path: save_bytes(words.encode() + b"\n", path))
    names = ["runs.csv", "study.json"]
    if len(study.axes) <= 2:
        for kind in ("svg", "png"):
            picture = figure_as(study, rows, found, kind, language, token)
            write_whole_file(str(folder / f"study.{kind}"), lambda path, picture=picture: save_bytes(picture, path))
            names.append(f"study.{kind}")
    if options.json:
        print_json(whole_record)
    else:
        _print(study, rows, found, folder, names)
    return 0


def _print(study: Study, rows: dict[int, Row], found: Sequence[Any], folder: Path, names: Sequence[str]) -> None:
    import numpy as np

    refused = [row for row in rows.values() if row.problem]
    print(f"{study.lesson}: {study.points} points, {study.runs} runs each, {len(refused)} of all without a result")
    for each in found:
        known = each.middle[np.isfinite(each.middle)]
        told = f"{known.min():.6g} … {known.max():.6g}" if len(known) else "nowhere finite"
        print(f"  {each.name}: {'share' if each.is_check else 'median'} {told}")
    if refused:
        print(f"  the first without one, run {min(row.index for row in refused)}: {min(refused, key=lambda row: row.index).problem}")
    print("\n".join(str(folder / name) for name in names))
