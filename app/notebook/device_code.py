"""Write the code of a design for a device from a notebook."""

from __future__ import annotations

from pathlib import Path

from observer_lab.lessons import all_lessons

from ..export.devices.folders import BODIES, device_files
from ..session.state.saved_state import SavedState
from ..session.state.token import write_token

__all__ = ["write_device"]


def write_device(lesson: str, folder: str, to: str = "c", *, ts: float | None = None, single: bool = False, part: str | None = None,
                 **knobs: object) -> list[str]:
    """Write the observer of a lesson, or a part of it alone, into a folder as code, its knobs given by name; the names of the files.

    Raises ValueError at an unknown lesson or kind, KnobError at a knob, DeviceError where no device can run the design.
    """
    lessons = all_lessons()
    if lesson not in lessons:
        raise ValueError(f"There is no lesson {str(lesson)[:40]}; there are {', '.join(lessons)}.")
    if to not in BODIES:
        raise ValueError(f"There is no kind {str(to)[:40]}; use {', '.join(BODIES)}.")
    taken = lessons[lesson]
    design = taken.apply(taken.start(), knobs)
    files = device_files(taken, taken.compute(design), write_token(taken, SavedState(design, "en")), to, ts=ts, single=single,
                         part=part)
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (Path(folder) / name).parent.mkdir(parents=True, exist_ok=True)
        (Path(folder) / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return list(files)
