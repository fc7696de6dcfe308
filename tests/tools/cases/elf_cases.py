# SPDX-License-Identifier: Apache-2.0
"""Tiny images for a Cortex-M7 that the tests of elfcheck compile and link."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

from checks.elf_image import Image
from checks.elf_isr import IsrReport, examine
from checks.elf_loops import Bound

GCC = "arm-none-eabi-gcc"
HARD_FLOAT = ("-mfpu=fpv5-d16", "-mfloat-abi=hard")

needs_gcc = pytest.mark.skipif(shutil.which(GCC) is None, reason=f"{GCC} is not installed")


def link(folder: Path, source: str, *options: str) -> Image:
    """Return the image of a C source whose entry is root(); options go to the compiler."""
    (folder / "tiny.c").write_text(source, "utf-8")
    words = ("-mcpu=cortex-m7", "-mthumb", "-O2", "-g", "-std=c11", "-ffreestanding", *options)
    link_words = ("-nostdlib", "-Wl,-e,root", "tiny.c", "-lgcc", "-o", "tiny.elf")
    subprocess.run([GCC, *words, *link_words], cwd=folder, check=True, timeout=60)
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


def examined(image: Image, rounds: Mapping[str, int] | None = None) -> IsrReport:
    """Return what the interrupt root() can reach, its loops by number of rounds."""
    bounds = {name: Bound(n, "the test says so") for name, n in (rounds or {}).items()}
    return examine(image, "root", bounds, has_float=False)


def only_problem(report: IsrReport) -> str:
    """Return the one problem that a report must have."""
    assert len(report.problems) == 1, report.problems
    return report.problems[0]
