"""Write a design in C: a project, an Arduino sketch, a process that speaks like a device."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from ...devices import DeviceDesign, Routine
from ...devices.routine import table
from ...engine import Plant
from .c_form import c_block, c_functions, c_number, c_tables
from .words import comment_word, header_line, readme_text, template

__all__ = ["MOST_TESTED", "arduino_sketch", "c_project", "lab_c", "lab_h", "simulator_files"]

MOST_TESTED = 400  # samples that the test replays: its constants take 25 bytes of text each
PUT_BACK, FARTHEST = 200.0, 1e6  # times its largest first state, at which a driven or knocked plant is put back; without any, at this


def c_project(design: DeviceDesign, source: str, single: bool = False) -> Mapping[str, str]:
    """The files of the folder by name. `source` says where the design comes from; `single` makes every number a float."""
    return {"lab.h": lab_h(design.routine, single), "lab.c": lab_c(design.routine, single), "lab_test.c": lab_test_c(design, single),
            "Makefile": template("Makefile"), "README.md": readme_text(design, source, single)}


def lab_h(routine: Routine, single: bool) -> str:
    """The header: sizes, period, names of the signals in their order, what can be called and read."""
    names = {"y": routine.y_names, "u": routine.u_names, "xhat": routine.x_names}
    listed = "\n".join(f" *   {name}[{k}]  {comment_word(word)}" for name, words in names.items() for k, word in enumerate(words))
    shown = "\n".join(f"extern lab_real lab_{name}[{routine.lengths[name]}];" for name in _shown(routine))
    return template("lab.h").format(
        listed=listed, real="float" if single else "double", period=c_number(routine.period, single), plain=f"{routine.period:.9g}",
        n=routine.lengths["xhat"], m=len(routine.u_names), p=len(routine.y_names), shown=shown,
        role="u is computed: u = r - K xhat, within its limits" if routine.drives else "u is given, and acts from this sample on",
        const="" if routine.drives else "const ")


def _shown(routine: Routine) -> tuple[str, ...]:
    """The tables that a program may read, and write where it is the command."""
    return tuple(dict.fromkeys(["xhat", *(name for name in routine.watched if name != "u"), *(["r"] if routine.commanded else [])]))


def lab_c(routine: Routine, single: bool) -> str:
    """The source: tables, the start, the step."""
    shown = _shown(routine)
    states = [each for each in routine.states]
    real = "lab_real"
    room = "\n".join(f"{'' if name in shown else 'static '}{real} {'lab_' if name in shown else ''}{name}[{length}];"
                     for name, length in {**{each.name: len(each.values) for each in states}, **routine.scratch}.items())
    block, helpers = c_block(routine, single), c_functions(routine, single)
    if "u[" not in block:
        block += "\n    (void)u;"
    zero = c_number(0.0, single)
    begin = "\n".join([*(f"    for (i = 0; i < {len(each.values)}; i++) {each.name}[i] = start_{each.name}[i];" for each in states),
                       *(f"    for (i = 0; i < {length}; i++) {name}[i] = {zero};" for name, length in routine.scratch.items())])
    sizes = "\n".join(f"#define {name} {value}" for name, value in routine.sizes.items() if _names(block, name))
    return template("lab.c").format(
        include="#include <math.h>\n" if any(f"{name}{'f' if single else ''}(" in block + helpers for name in ("sqrt", "floor")) else "",
        constants=c_tables(routine.constants, single, "static const lab_real"),
        starts=c_tables(states, single, "static const lab_real", "start_"), room=room,
        aliases="\n".join(f"#define {name} lab_{name}" for name in shown), sizes=sizes, helpers=helpers, begin=begin, block=block,
        const="" if routine.drives else "const ")


def _names(block: str, name: str) -> bool:
    return re.search(rf"\b{name}\b", block) is not None


def lab_test_c(design: DeviceDesign, single: bool) -> str:
    """The test: the readings of a run, and every number that the Python form found, bit for bit."""
    routine = design.routine
    found = design.expected(single=single)
    count = min(len(design.y), MOST_TESTED)
    given = {"y": design.y, "u": design.u, **({"r": design.r} if design.r is not None else {})}
    rows = [_rows(f"test_{name}", values[:count], single) for name, values in given.items() if name != "u" or not routine.drives]
    rows += [_rows(f"page_{name}", values[:count], single) for name, values in found.items()]
    m = len(routine.u_names)
    feed = [f"        for (i = 0; i < {m}; i++) u[i] = {c_number(0.0, single) if routine.drives else f'test_u[k * {m} + i]'};"]
    if design.r is not None:
        feed.append(f"        for (i = 0; i < {m}; i++) lab_r[i] = test_r[k * {m} + i];")
    compare = [f"        wrong += differ({'u' if name == 'u' else f'lab_{name}'}, page_{name} + k * {values.shape[1]}, {values.shape[1]});"
               for name, values in found.items()]
    return template("lab_test.c").format(rows="\n".join(rows), count=count, p=len(routine.y_names), m=m, feed="\n".join(feed),
                                         compare="\n".join(compare))


def _rows(name: str, values: np.ndarray, single: bool) -> str:
    numbers = [c_number(v, single) for v in values.ravel()]
    lines = ",\n    ".join(", ".join(numbers[k:k + 4]) for k in range(0, len(numbers), 4))
    return f"static const lab_real {name}[{len(numbers)}] = {{\n    {lines}\n}};"


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
