"""Write a design as an Arduino sketch: lab.c in float, a timer, and lines that `live` reads."""

from __future__ import annotations

from collections.abc import Mapping

from ...devices import DeviceDesign
from .c_project import lab_c, lab_h
from .live_line import header_line
from .readme import readme_text
from .words import template

__all__ = ["arduino_sketch"]


def arduino_sketch(design: DeviceDesign, source: str, single: bool = True) -> Mapping[str, str]:
    """The files of the sketch folder `lab`, whatever `single` says in float: an AVR's double has four bytes too."""
    routine = design.routine
    p, m = len(routine.y_names), len(routine.u_names)
    sketch = template("lab.ino", "arduino").format(
        header=header_line(routine), p=p, m=m, micros=round(routine.period * 1e6), pins=", ".join(f"A{k}" for k in range(p)),
        scales=", ".join(["1.0F"] * p), zeros=", ".join(["0.0F"] * p), outputs=", ".join(str(pin) for pin in (9, 10, 3, 5, 6, 11)[:m]),
        drives=int(routine.drives))
    return {"lab/lab.ino": sketch, "lab/lab.h": lab_h(routine, True), "lab/lab.c": lab_c(routine, True),
            "README.md": readme_text(design, source, True, ARDUINO_USE)}


ARDUINO_USE = ("open lab/lab.ino, set pins, scales and offsets at its head, and upload it; `observer-lab live --serial PORT` reads its "
               "lines. The sketch is in float; `--to c --float` has the test with the same bits.")
