"""Make the folder of a design for one of the bodies, and give it as files or as a zip."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Mapping
from types import MappingProxyType

from ...course.lesson import Lesson, Outcome
from ...devices import DeviceDesign, DeviceError, design_of_run
from ...text import text
from .c_project import arduino_sketch, c_project
from .fmu import fmu_folder
from .python_form import micropython_folder
from .simulink import simulink_folder
from .structured_text import structured_text_folder

__all__ = ["BODIES", "device_design", "device_files", "zip_of"]

Writer = Callable[[DeviceDesign, str, bool], Mapping[str, str | bytes]]
BODIES: Mapping[str, Writer] = MappingProxyType({
    "c": c_project, "arduino": arduino_sketch, "micropython": micropython_folder, "fmu": fmu_folder, "st": structured_text_folder,
    "simulink": simulink_folder})  # what writes the files for it, by the name of the body
NO_DEVICE = text("Lesson {id} has no observer, filter or controller that a device could run.")
NO_PARTS = text("Lesson {id} has no part that a device computes alone; leave the part out.")
NO_SUCH_PART = text("Lesson {id} has no part {part}; there are {parts}.")
BORN = (2020, 1, 1, 0, 0, 0)  # of every file in a zip, so that the same design gives the same bytes


def device_design(lesson: Lesson, outcome: Outcome, ts: float | None = None, part: str | None = None) -> DeviceDesign:
    """What a device computes for this design, or for a part of it alone, sampled every `ts` seconds.

    Raises DeviceError where there is nothing, or it breaks.
    """
    if part is not None:
        if part not in lesson.device_parts:
            raise DeviceError(NO_SUCH_PART.format(id=lesson.id, part=part[:40], parts=", ".join(lesson.device_parts))
                              if lesson.device_parts else NO_PARTS.format(id=lesson.id))
        return lesson.device_parts[part](outcome, ts)
    if lesson.device is not None:
        return lesson.device(outcome, ts)
    if outcome.run is None:
        raise DeviceError(NO_DEVICE.format(id=lesson.id))
    return design_of_run(outcome.run, ts)


def device_files(lesson: Lesson, outcome: Outcome, token: str, body: str, *, ts: float | None = None, single: bool = False,
                 part: str | None = None) -> Mapping[str, str | bytes]:
    """The files for a body by their names. Raises DeviceError."""
    knobs = ", ".join(f"{name} {value}" for name, value in outcome.design.values if value != lesson.start()[name])[:300]
    called = lesson.id if part is None else f"{lesson.id}, part {part}"
    source = f"lesson {called}, {f'with {knobs}' if knobs else 'default settings'}; state {token[:600]}"
    return BODIES[body](device_design(lesson, outcome, ts, part), source, single)


def zip_of(folder: str, files: Mapping[str, str | bytes]) -> bytes:
    """The files in one folder as a zip."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(zipfile.ZipInfo(f"{folder}/{name}", BORN), content, zipfile.ZIP_DEFLATED)
    return out.getvalue()
