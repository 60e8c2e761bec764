"""Exported designs on small processors: an ATmega328 under simavr and a Cortex-M3 under qemu-system-arm.

`python tests/benchmarks/boards.py` needs gcc-avr, avr-libc, simavr, gcc-arm-none-eabi, libnewlib-arm-none-eabi, qemu-system-arm. It prints
flash and RAM, and how many of the numbers of the page's run differ in any bit from the Python form.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from device_bodies import write_files

from observer_lab.export.devices import c_project
from observer_lab.export.devices.folders import device_design
from observer_lab.lessons import LESSONS

DESIGNS = ("noise", "saturation", "arm")  # two, four and four states
AVR_SAMPLES, ARM_SAMPLES = 12, 200
BARE = """
#include "lab.h"
int main(void) { static lab_real y[LAB_P], u[LAB_M]; lab_init(); for (;;) lab_step(y, u); }
"""
AVR_START = """
#include <avr/io.h>
#include <avr/interrupt.h>
#include <avr/sleep.h>
#include <stdio.h>
static int put(char c, FILE *f) { (void)f; while (!(UCSR0A & (1 << UDRE0))) {} UDR0 = c; return 0; }
static FILE out = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);
__attribute__((constructor)) static void begin(void) { UCSR0B = 1 << TXEN0; stdout = &out; }
__attribute__((destructor)) static void end(void) { cli(); sleep_enable(); sleep_cpu(); }
"""
ARM_START = """
extern int main(void);
extern void initialise_monitor_handles(void);
extern void exit(int);
extern unsigned _stack;
void _init(void) {}
void _fini(void) {}
void reset(void) { initialise_monitor_handles(); exit(main()); }
__attribute__((section(".vectors"), used)) void *vectors[2] = {&_stack, (void *)reset};
"""
ARM_MAP = """
ENTRY(reset)
SECTIONS {
  . = 0; .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) } .ARM.exidx : { *(.ARM.exidx*) }
  . = 0x20000000; .data : { *(.data*) } .bss : { *(.bss*) *(COMMON) } end = .; _stack = 0x20080000;
}
"""
FLAGS = ("-std=gnu99", "-ffp-contract=off", "-Os")


def run(command: list[str], folder: Path, seconds: float = 60.0) -> str:
    """What a command prints; fails with its words."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=seconds)
    assert done.returncode == 0 or "differ" in done.stdout + done.stderr, done.stderr[:2000]
    return done.stdout + done.stderr


def on_avr(folder: Path) -> tuple[int, int, str]:
    """Flash and RAM in bytes of a program that does nothing else, with the library's arithmetic in it, and the verdict of the test."""
    (folder / "start.c").write_text(AVR_START)
    chip = ["avr-gcc", "-mmcu=atmega328p", "-DF_CPU=16000000UL", *FLAGS]
    (folder / "bare.c").write_text(BARE)
    run([*chip, "-o", "bare.elf", "lab.c", "bare.c", "-lm"], folder)
    text, data, bss = map(int, run(["avr-size", "bare.elf"], folder).splitlines()[1].split()[:3])
    run([*chip, "-o", "test.elf", "lab.c", "lab_test.c", "start.c", "-lm"], folder)
    said = run(["simavr", "-m", "atmega328p", "-f", "16000000", "test.elf"], folder)
    return text + data, data + bss, _verdict(said)


def on_arm(folder: Path) -> tuple[int, int, str]:
    """Flash and RAM of lab.c alone on a Cortex-M3, and the verdict."""
    (folder / "start.c").write_text(ARM_START)
    (folder / "map.ld").write_text(ARM_MAP)
    chip = ["arm-none-eabi-gcc", "-mcpu=cortex-m3", "-mthumb", *FLAGS]
    run([*chip, "-c", "lab.c"], folder)
    text, data, bss = map(int, run(["arm-none-eabi-size", "lab.o"], folder).splitlines()[1].split()[:3])
    run([*chip, "--specs=rdimon.specs", "-nostartfiles", "-T", "map.ld", "-o", "test.elf", "lab.c", "lab_test.c", "start.c", "-lm"], folder)
    said = run(["qemu-system-arm", "-M", "mps2-an385", "-semihosting", "-nographic", "-monitor", "none", "-kernel", "test.elf"], folder)
    return text + data, data + bss, _verdict(said)


def _verdict(said: str) -> str:
    found = re.search(r"(\d+) samples: every bit|(\d+) numbers differ", said)
    return "no answer" if found is None else "same bits" if found[1] else f"{found[2]} numbers differ"


def main() -> int:
    """Print the table."""
    print(f"{'design':<14}{'states':>7}  {'body':<22}{'flash':>7}{'RAM':>6}  verdict")
    right = True
    for name in DESIGNS:
        lesson = LESSONS[name]
        outcome = lesson.compute(lesson.start())
        design = device_design(lesson, outcome)
        for body, single, samples, work in (("ATmega328 float", True, AVR_SAMPLES, on_avr), ("Cortex-M3 float", True, ARM_SAMPLES, on_arm),
                                            ("Cortex-M3 double", False, ARM_SAMPLES, on_arm)):
            short = type(design)(design.routine, design.y[:samples], design.u[:samples], None if design.r is None else design.r[:samples])
            with tempfile.TemporaryDirectory() as folder:
                flash, ram, verdict = work(write_files(Path(folder), c_project.c_project(short, "benchmark", single)))
            right &= verdict == "same bits"
            print(f"{name:<14}{len(design.routine.x_names):>7}  {body:<22}{flash:>7}{ram:>6}  {verdict}", flush=True)
    return int(not right)


if __name__ == "__main__":
    raise SystemExit(main())
