"""Write a design's plant in C beside its controller, as a process that speaks like a device."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...devices import DeviceDesign
from ...devices.routine import table
from ...engine import Plant
from .c_form import c_tables
from .c_project import lab_c, lab_h
from .live_line import header_line
from .words import template

__all__ = ["simulator_files"]

PUT_BACK, FARTHEST = 200.0, 1e6  # times its largest first state, at which a driven or knocked plant is put back; without any, at this


def simulator_files(design: DeviceDesign, plant: Plant, x0: np.ndarray) -> Mapping[str, str]:
    """lab.h, lab.c and plant.c; `plant` is sampled with the design's period."""
    routine = design.routine
    tables = [table("A", plant.A), table("B", plant.B), table("C", plant.C), table("x0", x0)]
    far = PUT_BACK * float(np.abs(x0).max(initial=0.0)) or FARTHEST
    main = template("plant.c", "simulator").format(n=plant.n, far=far, tables=c_tables(tables, False, "static const double", "plant_"),
                                                   header=header_line(routine))
    if not routine.drives:
        main = main.replace("lab_step(readings, u);", "lab_step(readings, u); /* u stays as it is: nothing is fed back */")
    return {"lab.h": lab_h(routine, False), "lab.c": lab_c(routine, False), "plant.c": main}
