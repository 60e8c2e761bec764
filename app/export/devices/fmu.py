"""Write a design as an FMI 2.0 unit for co-simulation."""

from __future__ import annotations

import hashlib
import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

from ...devices import DeviceDesign, Routine
from .c_project import lab_c, lab_h
from .words import identifier, readme_text, template

__all__ = ["fmu_folder", "fmu_variables"]

BORN = (2020, 1, 1, 0, 0, 0)  # of every file in the zip
COMPILE_S = 60.0  # how long the compiler may take
FMU_USE = ("give lab.fmu to a simulator that reads FMI 2.0 co-simulation, as `fmpy simulate lab.fmu`. Sources are inside; a library for "
           "this machine too if it had a C compiler.")


def fmu_folder(design: DeviceDesign, source: str, single: bool = False) -> Mapping[str, str | bytes]:
    """lab.fmu and its README; numbers are double, whatever `single` says."""
    routine = design.routine
    sources = {"lab.h": lab_h(routine, False), "lab.c": lab_c(routine, False), "fmu.c": _fmu_c(routine)}
    guid = hashlib.sha256("".join(sources.values()).encode()).hexdigest()[:32]
    sources["fmu.c"] = sources["fmu.c"].replace("@GUID@", guid)
    files: dict[str, str | bytes] = {"modelDescription.xml": _description(routine, guid)}
    files |= {f"sources/{name}": words for name, words in sources.items()}
    library = _library(sources)
    if library is not None:
        files[f"binaries/linux64/lab{'.so'}"] = library
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, content in files.items():
            packed.writestr(zipfile.ZipInfo(name, BORN), content, zipfile.ZIP_DEFLATED)
    return {"lab.fmu": out.getvalue(), "README.md": readme_text(design, source, False, FMU_USE)}


def fmu_variables(routine: Routine) -> list[tuple[str, str, str]]:
    """Name, causality and table entry in C of every variable, in the order of their value references."""
    taken: set[str] = set()
    rows = [(f"y_{identifier(name, taken)}", "input", f"y[{k}]") for k, name in enumerate(routine.y_names)]
    rows += [(f"u_{identifier(name, taken)}", "output" if routine.drives else "input", f"u[{k}]") for k, name in enumerate(routine.u_names)]
    if routine.commanded:
        rows += [(f"r_{identifier(name, taken)}", "input", f"lab_r[{k}]") for k, name in enumerate(routine.u_names)]
    return rows + [(f"xhat_{identifier(name, taken)}", "output", f"lab_xhat[{k}]") for k, name in enumerate(routine.x_names)]


def _fmu_c(routine: Routine) -> str:
    rows = fmu_variables(routine)
    return template("fmu.c", "fmu").format(
        getters="\n".join(f"    case {k}: return &{entry};" for k, (_, _, entry) in enumerate(rows)),
        p=len(routine.y_names), m=len(routine.u_names), guid="@GUID@")


def _description(routine: Routine, guid: str) -> str:
    rows = fmu_variables(routine)
    variables = "\n".join(
        f'    <ScalarVariable name={quoteattr(name)} valueReference="{k}" causality="{causality}" variability="continuous"'
        + ('><Real start="0.0"/></ScalarVariable>' if causality == "input" else ' initial="calculated"><Real/></ScalarVariable>')
        for k, (name, causality, _) in enumerate(rows))
    outputs = "".join(f'<Unknown index="{k + 1}"/>' for k, (_, causality, _) in enumerate(rows) if causality == "output")
    return template("modelDescription.xml", "fmu").format(guid=guid, period=repr(routine.period), variables=variables, outputs=outputs,
                                                          kind=quoteattr(routine.kind)[1:-1])


def _library(sources: Mapping[str, str]) -> bytes | None:
    """The compiled sources for this machine, None without a compiler or on a system other than 64-bit Linux."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None or not sys.platform.startswith("linux") or platform.machine() != "x86_64":
        return None
    with tempfile.TemporaryDirectory(prefix="observer-lab-") as folder:
        for name, words in sources.items():
            (Path(folder) / name).write_text(words, encoding="utf-8")
        command = [compiler, "-O2", "-std=c99", "-ffp-contract=off", "-fPIC", "-shared", "-o", "lab.so", "lab.c", "fmu.c", "-lm"]
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, timeout=COMPILE_S)
        except (OSError, subprocess.TimeoutExpired):
            return None
        return (Path(folder) / "lab.so").read_bytes() if done.returncode == 0 else None
