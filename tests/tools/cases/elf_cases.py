"""Tiny images for a Cortex-M7 that the tests of elfcheck compile and link."""

import shutil
import subprocess
from pathlib import Path

import pytest

from checks.elf_image import Image
from checks.elf_isr import IsrReport, examine

GCC = "arm-none-eabi-gcc"
HARD_FLOAT = ("-mfpu=fpv5-d16", "-mfloat-abi=hard")

needs_gcc = pytest.mark.skipif(shutil.which(GCC) is None, reason=f"{GCC} is not installed")


def link(folder: Path, source: str, *options: str) -> Image:
    """Return the image of a C source whose entry is root(); options go to the compiler."""
    (folder / "tiny.c").write_text(source, "utf-8")
    words = ("-mcpu=cortex-m7", "-mthumb", "-O2", "-g", "-std=c11", "-ffreestanding", *options)
    link_words = ("-nostdlib", "-Wl,-e,root", "tiny.c", "-lgcc", "-o", "tiny.elf")
    subprocess.run([GCC, *words, *link_words], cwd=folder, check=True)
    return Image(folder / "tiny.elf")


def assembled(body: str) -> str:
    """Return a C source whose root() is these lines of assembler, one after the other."""
    lines = "".join(f'"{line.strip()}\\n"' for line in body.strip().splitlines())
    return f"__attribute__((naked, used)) void root(void) {{ __asm volatile({lines}); }}"


# Counts down from five.
LOOP = assembled(
    """movs r0, #5
    1: subs r0, #1
    bne 1b
    bx lr"""
)


def examined(image: Image, *bounded: str) -> IsrReport:
    """Return what the interrupt root() can reach; the loops of these functions have a bound."""
    bounds = dict.fromkeys(bounded, "the test says so")
    return examine(image, "root", bounds)


def only_problem(report: IsrReport) -> str:
    """Return the one problem that a report must have."""
    assert len(report.problems) == 1, report.problems
    return report.problems[0]
