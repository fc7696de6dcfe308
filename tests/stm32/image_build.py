# SPDX-License-Identifier: Apache-2.0
"""Compiles the little images in images/ that test the emulator, and the firmware's variants."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
IMAGES = Path(__file__).resolve().parent / "images"
CORE = ("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard")
CHECKS = ("-std=gnu11", "-O2", "-ffreestanding", "-Wall", "-Wextra", "-Wconversion", "-Werror")


def build_image(name: str, folder: Path) -> Path:
    """Compile and link images/<name>.c with the start-up; return the .elf."""
    elf = folder / f"{name}.elf"
    sources = [IMAGES / f"{name}.c", IMAGES / "image_start.c"]
    script = f"-T{IMAGES / 'image.ld'}"
    command = ["arm-none-eabi-gcc", *CORE, *CHECKS, "-nostdlib", script, *sources, "-o", elf]
    subprocess.run([str(word) for word in command], check=True)
    return elf


def build_with(setting: str, value: str) -> Path:
    """Build the firmware with a setting of board_config.h; return the .elf."""
    folder = ROOT / "build" / f"mcu-stm32h743-{setting.lower()}-{value}"
    flag = f"-DCMAKE_C_FLAGS=-D{setting}={value}"
    configure = ["cmake", "--preset", "mcu-stm32h743", "-B", str(folder), flag]
    subprocess.run(configure, cwd=ROOT, check=True, capture_output=True)
    command = ["cmake", "--build", str(folder), "--target", "firmware"]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "hal" / "stm32h743" / "firmware.elf"
