"""Files of records as loggers, programs and people write them; each with what must be read, or the words of its refusal.

    python tests/engine/record_files.py

All files but those that are refused tell of one record: step 0.5 s, input u, output y. None may be read as another one.
"""

from __future__ import annotations

import datetime
import io
import json
import re
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).resolve().parents[2])]

from observer_lab.engine import EngineError
from observer_lab.engine.identification import Record, load_record

ROWS, STEP = 60, 0.5
TIMES = STEP * np.arange(ROWS)
INPUTS = np.where(np.arange(ROWS) // 5 % 2, 60.0, 20.5)
OUTPUTS = np.array([round(20 + 36.125 * (1 - 0.97 ** k) + 0.31 * np.sin(1.7 * k), 4) for k in range(ROWS)])
START = datetime.datetime(2026, 3, 29, 0, 59, 50)  # UTC, just before Europe sets its clocks
EPOCH = int((START - datetime.datetime(1970, 1, 1)).total_seconds())
CET = datetime.timedelta(hours=1)


@dataclass(frozen=True)
class File:
    """A file: what is asked, and either words that must be in its refusal or the record, of which `gone` rows of y are missing.

    thousand: u and y a thousand times as large. needs: the library of the extra that reads it. notes: words that must be said.
    """

    name: str
    data: bytes
    given: dict[str, Any] = field(default_factory=dict)
    refused: str = ""
    gone: tuple[int, ...] = ()
    rows: int = ROWS
    thousand: bool = False
    notes: str = ""
    needs: str = ""


def table(time: Callable[[int], str], head: str = "t [s],u,y", mark: str = ",", u: Callable[[int], str] | None = None,
          y: Callable[[int], str] | None = None, more: Callable[[int], str] | None = None, end: str = "\n", begin: str = "") -> str:
    """The text of a table of all rows."""
    lines = [head] if head else []
    for k in range(ROWS):
        cells = [time(k), u(k) if u else f"{INPUTS[k]:g}", y(k) if y else f"{OUTPUTS[k]:.4f}"]
        lines.append(mark.join([*cells, *([more(k)] if more else [])]))
    return begin + end.join(lines) + end


def seconds(k: int) -> str:
    return f"{TIMES[k]:.1f}"


def comma(words: Callable[[int], str]) -> Callable[[int], str]:
    return lambda k: words(k).replace(".", ",")


def number(factor: float, start: float = 0.0, digits: int = 0) -> Callable[[int], str]:
    return lambda k: f"{start + TIMES[k] * factor:.{digits}f}"


def whole(per_second: int, start: int = EPOCH) -> Callable[[int], str]:
    return lambda k: str(start * per_second + k * per_second // 2)


def moment(form: str, away: datetime.timedelta = datetime.timedelta(), tail: str = "") -> Callable[[int], str]:
    def words(k: int) -> str:
        at = START + away + datetime.timedelta(seconds=float(TIMES[k]))
        return at.strftime(form).replace("%3", f"{at.microsecond // 1000:03d}") + tail
    return words


def half(words: str) -> Callable[[int], str]:
    """y with that cell in rows 10, 11 and 30."""
    return lambda k: words if k in GONE else f"{OUTPUTS[k]:.4f}"


def at_row(row: int, words: str) -> Callable[[int], str]:
    return lambda k: words if k == row else f"{OUTPUTS[k]:.4f}"


def eu_thousands(values: np.ndarray) -> Callable[[int], str]:
    return lambda k: f"{1000 * values[k]:,.1f}".replace(",", "_").replace(".", ",").replace("_", ".")


GONE = (10, 11, 30)
CHOSEN = {"inputs": ("heater",), "outputs": ("temp",)}
OWN = {"time": "t", "inputs": ("u",), "outputs": ("y",)}
Y1 = lambda k: f"{OUTPUTS[k]:.4f}"  # noqa: E731
U1 = lambda k: f"{INPUTS[k]:g}"  # noqa: E731


def times() -> list[File]:
    """Units, epochs, dates, days, row numbers."""
    def file(name: str, text: str, **said: Any) -> File:
        return File(name, text.encode(), **said)
    ms = number(1000)
    return [
        file("time_ms", table(ms, "time_ms,heater,temp"), given=CHOSEN),
        file("t/ms", table(ms, "t/ms,u,y")), file("t / ms", table(ms, "t / ms,u,y")),
        file("t in ms", table(ms, "t in ms,u,y")), file("time [ms]", table(ms, "time [ms],u,y")),
        file("time (ms)", table(ms, "time (ms),u,y")),
        file("Time(s)", table(seconds, "Time(s),u,y")), file("timeUS", table(number(1e6), "TimeUS,u,y")),
        file("elapsed_ms alone", table(ms, "elapsed_ms,u,y")), file("millis", table(ms, "millis,u,y")),
        file("t [min]", table(number(1 / 60, digits=9), "t [min],u,y")), file("t [h]", table(number(1 / 3600, digits=11), "t [h],u,y")),
        file("t [furlong]", table(seconds, "t [furlong],u,y"), refused="unit furlong"),
        file("no unit, seconds", table(seconds, "t,u,y"), notes="names no unit"),
        file("no unit, whole numbers of 500", table(ms, "t,u,y"), refused="names no unit, and 0 can be"),
        file("the same with its unit given", table(ms, "t,u,y"), given={**OWN, "time": "t[ms]"}),
        file("PX4 timestamp in us", table(number(1e6, 3e8), "timestamp,u,y"), refused="can be seconds, milliseconds"),
        file("us since boot, as large as Unix s", table(number(1e6, 1.2e9), "timestamp,u,y"), refused="can be seconds, milliseconds"),
        file("ns since boot, as large as Unix ms", table(number(1e9, 1.5e12), "time,u,y"), refused="can be seconds, milliseconds"),
        file("Unix s", table(number(1, EPOCH, 1), "time,u,y"), notes="Unix time in s"),
        file("Unix ms", table(whole(1000), "time,u,y"), notes="Unix time in ms"),
        file("Unix us", table(whole(10**6), "time,u,y"), notes="Unix time in us"),
        file("ROS ns", table(whole(10**9), "%time,field.u,field.y"), given={"inputs": ("field.u",), "outputs": ("field.y",)},
             notes="Unix time in ns"),
        file("Unix ms called s", table(whole(1000), "time [s],u,y"), refused="longer than a thousand years"),
        file("Excel days", table(number(1 / 86400, 46110, 12), "date,u,y"), notes="days of Excel"),
        file("Excel days called t", table(number(1 / 86400, 46110, 12), "t,u,y"), notes="days of Excel"),
        file("days or seconds", table(number(1, 46110, 1), "t,u,y"), refused="can be seconds, milliseconds, microseconds, days"),
        file("MATLAB days", table(number(1 / 86400, 740070, 12), "t,u,y"), notes="days of MATLAB"),
        file("ISO", table(moment("%Y-%m-%dT%H:%M:%S.%f"), "time,u,y")),
        file("ISO with Z and blank", table(moment("%Y-%m-%d %H:%M:%S.%fZ"), "time,u,y")),
        file("ISO over a change of clocks", table(lambda k: moment("%Y-%m-%dT%H:%M:%S.%f", CET, "+01:00")(k) if k < 20
             else moment("%Y-%m-%dT%H:%M:%S.%f", 2 * CET, "+02:00")(k), "time,u,y")),
        file("some offsets only", table(lambda k: moment("%Y-%m-%dT%H:%M:%S.%f", tail="" if k < 5 else "Z")(k), "time,u,y"),
             refused="row 7: some times name their offset"),
        file("German dates", table(moment("%d.%m.%Y %H:%M:%S,%f"), "Time;u;y", ";", comma(U1), comma(Y1))),
        file("American dates and PM", table(moment("%m/%d/%Y %I:%M:%S.%f %p"), "Time,u,y")),
        file("day or month", table(lambda k: f"03/04/2026 10:00:{TIMES[k]:04.1f}", "Time,u,y"), refused="order of day and month"),
        file("date and clock apart", table(moment("%H:%M:%S.%f"), "Date,Time,u,y").replace("\n00:", "\n2026-03-29,00:").replace(
             "\n01:", "\n2026-03-29,01:")),
        file("clock alone", table(moment("%H:%M:%S.%f"), "time,u,y")),
        file("no time, a step", table(lambda k: str(k), "n,u,y"), given={"step": STEP}, notes="rows were counted"),
        file("no time, no step", table(lambda k: str(k), "n,u,y"), refused="no column is called t or time"),
        file("unnamed index", table(lambda k: f"{k},{seconds(k)}", ",t [s],u,y")),
    ]


def numbers() -> list[File]:
    """Decimal signs, signs between thousands, odd numbers."""
    def file(name: str, text: str, **said: Any) -> File:
        return File(name, text.encode(), **said)
    k1000 = lambda values: lambda k: f"{1000 * values[k]:,.1f}"  # noqa: E731
    return [
        file("semicolons and decimal commas", table(comma(seconds), "t [s];u;y", ";", comma(U1), comma(Y1))),
        file("quoted decimal commas between commas", table(lambda k: f'"{comma(seconds)(k)}"', "t [s],u,y", ",",
             lambda k: f'"{comma(U1)(k)}"', lambda k: f'"{comma(Y1)(k)}"')),
        file("2,000 beside points", table(seconds, "t [s];u;y", ";", lambda k: f"{INPUTS[k] * 1000:,.0f}",
             lambda k: f"{1000 * OUTPUTS[k]:.1f}"), thousand=True, notes="between thousands"),
        file("2,000 alone", table(lambda k: str(k), "t [s];u;y", ";", lambda k: f"{2000 + k:,}", lambda k: f"{3000 + k:,}"),
             refused="2,000 can be 2.000 or 2000"),
        file("2.000 beside whole numbers", table(lambda k: str(k), "t [s];u;y", ";", lambda k: f"{900 + 10 * k:,}".replace(",", "."),
             lambda k: str(3000 + k)), refused="1.000 can be 1.000 or 1000"),
        file("English thousands", table(seconds, "t [s];u;y", ";", k1000(INPUTS), k1000(OUTPUTS)), thousand=True),
        file("European thousands", table(comma(seconds), "t [s];u;y", ";", eu_thousands(INPUTS), eu_thousands(OUTPUTS)), thousand=True),
        file("Swiss thousands", table(seconds, "t [s];u;y", ";", lambda k: k1000(INPUTS)(k).replace(",", "'"),
             lambda k: k1000(OUTPUTS)(k).replace(",", "'")), thousand=True),
        file("two decimal signs", table(seconds, "t [s];u;y", ";", comma(U1), Y1), refused="use one decimal sign"),
        file("three decimals everywhere", table(lambda k: f"{TIMES[k]:.3f}", "t [s],u,y", ",", lambda k: f"{INPUTS[k]:.3f}")),
        file("decimal comma as separator", table(comma(seconds), "t [s],u,y", ",", comma(U1), comma(Y1)),
             refused="the comma stands both between the columns and in the numbers"),
        file("2_1.5", table(seconds, y=at_row(4, "2_1.5")), refused="row 6, column y: 2_1.5 is not a number"),
        file("a unit in the cell", table(seconds, y=at_row(4, "21.5 V")), refused="row 6, column y: 21.5 V is not a number"),
        file("0x1F", table(seconds, y=at_row(4, "0x1F")), refused="row 6, column y: 0x1F is not a number"),
        file("true minus and exponents", table(seconds, y=lambda k: f"{OUTPUTS[k]:.8e}", u=lambda k: "20.5" if k % 10 < 5 else "+6.0E1")),
    ]


def layouts() -> list[File]:
    """Heads, units, remarks, separators, encodings, quotes."""
    def file(name: str, text: str, code: str = "utf-8", **said: Any) -> File:
        return File(name, text.encode(code), **said)
    plain = table(seconds)
    return [
        file("plain", plain), file("tabs", table(seconds, "t [s]\tu\ty", "\t")), file("bars", table(seconds, "t [s]|u|y", "|")),
        file("blanks, units in the head", table(seconds, "t [s]   u [V]   y [V]", "   ")),
        file("one blank, units in the head", table(seconds, "t [s] u [V] y [V]", " ")),
        file("sep=", "sep=;\n" + table(comma(seconds), "t [s];u;y", ";", comma(U1), comma(Y1))),
        file("unit row", table(seconds, "t,u,y\ns,V,mm")), file("unit row in brackets, ms", table(number(1000), "t,u,y\n[ms],[V],[mm]")),
        file("metadata", "Logger 12\nSerial: A7, room 3\n\n" + plain, notes="Lines before the head line"),
        file("TOA5", '"TOA5","CR1000","program","4"\n' + table(moment('"%Y-%m-%d %H:%M:%S.%f"'),
             '"TIMESTAMP","u","y"\n"TS","V","Deg C"\n"","Smp","Smp"'), notes="Lines before the head line"),
        file("remarks and their rows", "# made by hand\n# twice\n" + plain.replace("\n2.0,", "\n# a pause\n2.0,")),
        file("true row numbers", "# made by hand\n# twice\n" + table(seconds, y=at_row(4, "broken")),
             refused="row 8, column y: broken"),
        file("head in a remark", "# t [s] u y\n" + table(seconds, "", " ")),
        file("no head line", table(seconds, ""), refused="no head line"),
        file("no head line, by number", table(seconds, ""), given={"time": "1[s]", "inputs": ("2",), "outputs": ("3",)}),
        file("BOM", plain, "utf-8-sig"), file("UTF-16", plain, "utf-16"),
        file("Windows-1252", table(number(1e6), "t [µs],u [V],y [°C]"), "cp1252", notes="Windows-1252"),
        file("old Mac and Windows ends", table(seconds, end="\r\n")),
        file("quoted heads with a comma", table(seconds, '"t [s]","u","y","a, b"', more=lambda k: '"x, y"'), notes="not used: a, b"),
        file("last separator", table(seconds, "t [s],u,y,", more=lambda k: "")),
        file("blanks round cells", table(seconds, " t [s] , u , y ", " , ")),
        file("text in a column that nobody chose", table(seconds, "t [s],u,y,mode", more=lambda k: "MAN" if k < 9 else "AUTO")),
        file("u_valid is a flag", table(seconds, "t [s],u,y,u_valid", more=lambda k: str(k % 2)), notes="not used: u_valid"),
        file("two columns called u", table(seconds, "t [s],u,y,u", more=lambda k: "1"), refused="two columns are called u"),
        file("the head line again", plain + plain, refused="head line stands again in row 62"),
        file("cut off", plain.rstrip("\n")[:-14] + "\n", rows=ROWS - 1, notes="row 61, is cut off"),
        file("a longer row", plain.replace("\n2.0,20.5,", "\n2.0,20.5,7,"), refused="row 6 the number of values differs"),
        File("a spreadsheet", b"PK\x03\x04" + bytes(100), refused="is a spreadsheet"),
        File("a picture", b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 4, refused="not UTF-8 text"),
        file("a plant", '{"A": [[-1]], "B": [[1]], "C": [[1]]}', refused="open a plant with --plant"),
    ]


def values() -> list[File]:
    """Missing, marked, infinite, stuck, in a wrong order."""
    def file(name: str, text: str, **said: Any) -> File:
        return File(name, text.encode(), **said)
    shuffled = [*range(20), 25, *range(20, 25), *range(26, ROWS)]
    marks = table(seconds, y=half("-9999"))
    return [
        *(file(f"missing as {words or 'empty'}", table(seconds, y=half(words)), gone=GONE, notes="missing: 3")
          for words in ("", "NaN", "#N/A", "null", "-")),
        file("Inf", table(seconds, y=half("Inf")), gone=GONE, notes="infinite and count as missing: 3, the first in row 12"),
        file("1e999", table(seconds, y=half("1e999")), gone=GONE, notes="infinite"),
        file("-9999", marks, refused="holds -9999 in 3 rows, the first is row 12"),
        file("-9999 is missing", marks, given={"missing": ("-9999",)}, gone=GONE,
             notes="the mark −9999 of a missing value stands in 3 rows"),
        file("two marks", table(seconds, y=lambda k: ("-9999" if k == 10 else "999999") if k in GONE else Y1(k)), refused="far from all"),
        file("an empty input", table(seconds, u=lambda k: "" if k == 6 else U1(k)), refused="input u is missing in row 8"),
        file("an input that holds", table(seconds, u=lambda k: U1(k) if k % 5 == 0 else ""), given={"hold": True}, notes="was held"),
        file("stuck", table(seconds, y=lambda k: f"{OUTPUTS[min(k, 30)] if k < 55 else OUTPUTS[k]:.4f}"), given={"missing": ("stuck",)},
             gone=tuple(range(31, 55)), notes="rows 33 to 56 were stuck"),
        file("times out of order", "t [s],u,y\n" + "".join(f"{seconds(k)},{U1(k)},{Y1(k)}\n" for k in shuffled),
             refused="row 23 is not later"),
        file("a time twice", table(lambda k: seconds(k - (k == 9))), refused="row 11 is not later"),
        file("a time missing", table(lambda k: "" if k == 9 else seconds(k)), refused="row 11 has no time"),
    ]


def matrices() -> list[File]:
    """MATLAB's files."""
    from scipy.io import savemat

    def file(name: str, variables: dict[str, Any], **said: Any) -> File:
        out = io.BytesIO()
        savemat(out, variables)
        return File(name + ".mat", out.getvalue(), **said)
    one = {"t": TIMES, "u": INPUTS, "y": OUTPUTS}
    return [
        file("t, u, y", one, notes="names no unit"), file("columns", {key: value[:, None] for key, value in one.items()}),
        file("in a struct", {"log": one}), file("another length", {**one, "u": INPUTS[:-1]}, refused="Variable u has the size 1×59"),
        file("a matrix", {"A": np.eye(2), "B": np.ones((2, 1)), "C": np.ones((1, 2))}, refused="holds a plant"),
        file("ms", {**one, "t": 1000 * TIMES}, refused="names no unit"),
        File("version 7.3.mat", b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n" + bytes(100), refused="option -v7"),
    ]


def extras() -> list[File]:
    """Files that libraries of the extra `records` read; those that are not installed are left out."""
    out = []
    if find_spec("pyarrow"):
        import pyarrow as arrow
        import pyarrow.parquet as parquet

        moments = np.datetime64("2026-03-29T00:59:50", "ns") + (1e9 * TIMES).astype("timedelta64[ns]")
        for name, time in (("t [s]", TIMES), ("time", moments), ("time_ms", (1000 * TIMES).astype(int))):
            file = io.BytesIO()
            parquet.write_table(arrow.table({name: time, "u": INPUTS, "y": OUTPUTS, "mode": ["A"] * ROWS}), file)
            out.append(File(f"Parquet, {name}", file.getvalue(), needs="pyarrow"))
        out.append(File("Parquet, cut off", out[0].data[:300], refused="cannot be read", needs="pyarrow"))
    if find_spec("asammdf"):
        from asammdf import MDF, Signal

        mdf = MDF()
        mdf.append([Signal(OUTPUTS, TIMES, name="y", unit="degC")])
        mdf.append([Signal(INPUTS[::5], TIMES[::5], name="u", unit="V")])  # logged when it changes
        with tempfile.TemporaryDirectory() as folder:
            data = Path(mdf.save(Path(folder) / "a.mf4")).read_bytes()
        mdf.close()
        out.append(File("MDF, two clocks", data, needs="asammdf"))
        out.append(File("MDF, no such channel", data, given={"outputs": ("z",)}, refused="no column z", needs="asammdf"))
    if find_spec("mcap"):
        from mcap.writer import Writer

        file = io.BytesIO()
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("plant", "jsonschema", b"{}")
        channels = {key: writer.register_channel(f"/{key}", "json", schema) for key in ("u", "y")}
        for k in range(ROWS):
            for key, value in (("u", INPUTS[k]), ("y", OUTPUTS[k])):
                at = EPOCH * 10**9 + k * 500_000_000
                writer.add_message(channels[key], at, json.dumps({"value": value, "ok": True}).encode(), at)
        writer.finish()
        chosen = {"inputs": ("/u.value",), "outputs": ("/y.value",)}
        out.append(File("MCAP", file.getvalue(), given=chosen, needs="mcap"))
        out.append(File("MCAP, nothing chosen", file.getvalue(), refused="No column is an output y", needs="mcap"))
    return out


def all_files() -> list[File]:
    """Every file of the table."""
    return [*times(), *numbers(), *layouts(), *values(), *matrices(), *extras()]


def wrong(file: File) -> tuple[str, str]:
    """What is wrong with the answer to a file, "" where nothing is, and the answer in words."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / (file.name.replace("/", " ") if file.name.endswith(".mat") else "log.csv")
        path.write_bytes(file.data)
        try:
            record = load_record(path, **file.given)
        except EngineError as problem:
            said = str(problem)
            good = bool(file.refused) and file.refused.lower() in said.lower() and said.endswith(".") and "\n" not in said
            return "" if good else "another refusal than expected", said
    told = f"{record.size} {' '.join(record.notes)}"
    return _differs(file, record), told


def _differs(file: File, record: Record) -> str:
    if file.refused:
        return "read, and should be refused"
    factor = 1000.0 if file.thousand else 1.0
    y = factor * OUTPUTS[:file.rows]
    y[list(file.gone)] = np.nan
    for name, found, true in (("t", record.t, TIMES[:file.rows]), ("u", record.u[:, 0], factor * INPUTS[:file.rows]),
                              ("y", record.y[:, 0], y)):
        if found.shape != true.shape or not np.allclose(found, true, rtol=1e-6, atol=2e-5, equal_nan=True):
            return f"{name} is another one"
    return "" if re.search(re.escape(file.notes), " ".join(record.notes)) else f"not said: {file.notes}"


if __name__ == "__main__":
    files, silent = all_files(), 0
    for file in files:
        fault, answer = wrong(file)
        silent += bool(fault)
        print(f"{'WRONG' if fault else 'right'}  {file.name:34} {answer[:150]}{'   <- ' + fault if fault else ''}")
    print(f"{len(files)} files, {silent} wrong")
    sys.exit(bool(silent))
