"""Build an exported design with a compiler and run its own test: what each body says of the run."""

import math
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import playwright

from observer_lab.devices import DeviceDesign
from observer_lab.export.devices.fmu import fmu_variables

STRICT = ("-std=c99", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANITIZERS = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def write_files(folder: Path, files: Mapping[str, str | bytes]) -> Path:
    """The folder with these files in it."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return folder


def run_c(folder: Path, flags: Sequence[str], compiler: Sequence[str] = ("gcc",)) -> str:
    """What the test of a folder prints, compiled with these flags; fails with the compiler's words."""
    program = folder / "lab_test"
    built = subprocess.run([*compiler, *flags, *STRICT, "-o", str(program), "lab.c", "lab_test.c", "-lm"], cwd=folder, capture_output=True,
                           text=True)
    assert built.returncode == 0, built.stderr[:2000]
    ran = subprocess.run([str(program)], capture_output=True, text=True, preexec_fn=_unbounded)
    assert ran.returncode in (0, 1), ran.stderr[:2000]
    return ran.stdout.strip()


def _unbounded() -> None:
    """A sanitizer maps terabytes; a server that ran in this process before has bounded its memory."""
    resource.setrlimit(resource.RLIMIT_DATA, (resource.getrlimit(resource.RLIMIT_DATA)[1],) * 2)


WASI = """
const { WASI } = require("wasi"), fs = require("fs");
const wasi = new WASI({ version: "preview1", args: [], env: {} });
WebAssembly.compile(fs.readFileSync(process.argv[2])).then(async (code) => {
  process.exit(wasi.start(await WebAssembly.instantiate(code, wasi.getImportObject())) || 0);
});
"""


def run_wasm(folder: Path) -> str:
    """What the test prints as WebAssembly under Node, compiled by ziglang."""
    (folder / "run.js").write_text(WASI)
    built = subprocess.run([sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi", "-O2", "-std=c99", "-ffp-contract=off", "-o",
                            "lab_test.wasm", "lab.c", "lab_test.c"], cwd=folder, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr[:2000]
    node = shutil.which("node") or str(Path(playwright.__file__).parent / "driver" / "node")
    ran = subprocess.run([node, "--no-warnings", "run.js", "lab_test.wasm"], cwd=folder, capture_output=True, text=True)
    assert ran.returncode in (0, 1), ran.stderr[:2000]
    return ran.stdout.strip()


def run_python(folder: Path) -> str:
    """What the test of the plain Python folder prints."""
    ran = subprocess.run([sys.executable, "-B", "lab_test.py"], cwd=folder, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr[:2000]
    return ran.stdout.strip()


def st_step(block: str) -> tuple[dict[str, list[float]], str]:
    """Tables of a function block by name, and its body as Python: an interpreter of the subset, line by line."""
    declared = dict(re.findall(r"^    (\w+) : (.+);$", block, re.MULTILINE))
    names: dict[str, object] = {"SQRT": math.sqrt, "FLOOR": math.floor}
    for name, kind in declared.items():
        if kind.startswith("ARRAY"):
            start = kind.partition(":= ")[2]
            names[name] = [float(v) for v in start[1:-1].split(",")] if start else [0.0] * (int(re.findall(r"\.\.(\d+)", kind)[0]) + 1)
        elif ":=" in kind:
            names[name] = int(kind.partition(":= ")[2])
    lines, depth = [], 0
    for line in block[block.rindex("END_VAR") + 7:block.index("END_FUNCTION_BLOCK")].splitlines():
        words = line.strip()
        if words in ("END_FOR;", "END_IF;"):
            depth -= 1
            continue
        if words == "ELSE":
            lines.append("    " * (depth - 1) + "else:")
            continue
        pad = "    " * depth
        if match := re.fullmatch(r"FOR (\w+) := (.+) TO (.+) DO", words):
            lines.append(f"{pad}for {match[1]} in range({match[2]}, {match[3]} + 1):")
            depth += 1
        elif match := re.fullmatch(r"IF (.+) THEN", words):
            test = match[1].replace("<>", "!=").replace(" AND ", " and ").replace(" OR ", " or ")
            lines.append(f"{pad}if {re.sub(r'(?<![<>!=])=(?!=)', '==', test)}:")
            depth += 1
        elif words:
            assert re.fullmatch(r"[\w\[\]() +*-]+ := .+;", words), words
            lines.append(pad + words[:-1].replace(":=", "="))
    assert depth == 0
    return names, "\n".join(lines)  # type: ignore[return-value]


def st_differences(block: str, design: DeviceDesign) -> int:
    """How many numbers the function block gives otherwise than the Python form, over the design's run."""
    names, body = st_step(block)
    code, found, wrong = compile(body, "<block>", "exec"), design.expected(), 0
    for k in range(len(design.y)):
        names["v_y"][:] = design.y[k].tolist()
        if not design.routine.drives:
            names["v_u"][:] = design.u[k].tolist()
        if design.r is not None:
            names["v_r"][:] = design.r[k].tolist()
        exec(code, names)
        for name, rows in found.items():
            wrong += int(np.sum(np.array(names[f"v_{name}"]) != rows[k]))
    return wrong


def fmu_differences(path: Path, design: DeviceDesign) -> int:
    """How many outputs of the unit under FMPy differ from the Python form, over the design's run."""
    from fmpy import extract, read_model_description
    from fmpy.fmi2 import FMU2Slave

    unpacked, described = extract(str(path)), read_model_description(str(path))
    rows, routine = fmu_variables(design.routine), design.routine
    unit = FMU2Slave(guid=described.guid, unzipDirectory=unpacked, modelIdentifier="lab", instanceName="lab")
    unit.instantiate()
    unit.setupExperiment(startTime=0.0)
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    inputs = [k for k, row in enumerate(rows) if row[1] == "input"]
    given = [design.y, *([] if routine.drives else [design.u]),
             *([np.zeros((len(design.y), len(routine.u_names))) if design.r is None else design.r] if routine.commanded else [])]
    values, found, wrong = np.hstack(given), design.expected(), 0
    shown = {name: [k for k, row in enumerate(rows) if row[2].startswith(entry)] for name, entry in (("xhat", "lab_xhat["), ("u", "u["))}
    start = next((np.array(each.values) for each in routine.states if each.name == "r"), None)
    if design.r is None and start is not None:
        values[:, -len(start):] = start
    for k in range(len(values)):
        unit.setReal(inputs, values[k].tolist())
        unit.doStep(currentCommunicationPoint=k * routine.period, communicationStepSize=routine.period)
        for name in ("xhat", "u") if routine.drives else ("xhat",):
            if name in found:
                wrong += int(np.sum(np.array(unit.getReal(shown[name])) != found[name][k]))
    unit.terminate()
    unit.freeInstance()
    shutil.rmtree(unpacked)
    return wrong
