"""The image's own record of every tick, read out of its memory as a debugger would."""

import subprocess
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from elftools.elf.elffile import ELFFile

from tests.stm32.emulator import Chip

ROOT = Path(__file__).resolve().parents[2]
PLACES = ("ring", "n_written", "capacity", "size")
FIELDS = (
    *("tick", "config", "clock", "counts", "index_counts", "n_index", "edge_clock", "u_nm"),
    *("x_nm", "z_nm", "inputs", "request", "out_u_nm", "out_x_nm", "out_z_nm", "force_q6"),
)
SIGNED = frozenset(name for name in FIELDS if name.endswith(("_nm", "_q6")))

Record = dict[str, int]


@cache
def compile_layout() -> list[int]:
    """Compile layout.c as the image is compiled, and return its numbers, the same every time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "layout.o"
        rooms = sorted((ROOT / "firmware").glob("*/"))
        includes = [f"-I{place}" for place in (*rooms, ROOT / "hal" / "include")]
        core = ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=soft", "-std=c11"]
        source = Path(__file__).with_name("layout.c")
        command = ["arm-none-eabi-gcc", *core, *includes, "-c", source, "-o", path]
        subprocess.run([str(word) for word in command], check=True)
        with path.open("rb") as file:
            raw = ELFFile(file).get_section_by_name(".rodata").data()
    return [int.from_bytes(raw[i : i + 4], "little") for i in range(0, len(raw), 4)]


class Trace:
    """Reads records in order, beside the image's own recorder."""

    def __init__(self, chip: Chip) -> None:
        numbers = compile_layout()
        assert len(numbers) == len(PLACES) + len(FIELDS)
        self._chip = chip
        self._at = dict(zip(PLACES, numbers, strict=False))
        self._fields = list(zip(FIELDS, numbers[len(PLACES) :], strict=True))
        self._base = chip.image.symbols["g_cam"]
        self._n_read = self._n_resets = 0

    def _word(self, place: str) -> int:
        return int.from_bytes(self._chip.read_memory(self._base + self._at[place], 4), "little")

    def take(self) -> Iterator[Record]:
        """Return all records since the last call."""
        if len(self._chip.resets) != self._n_resets:
            self._n_resets, self._n_read = len(self._chip.resets), 0
        n_written = self._word("n_written")
        assert (n_written - self._n_read) & 0xFFFFFFFF <= self._at["capacity"], "records are lost"
        while self._n_read != n_written:
            place = self._n_read % self._at["capacity"]
            at = self._base + self._at["ring"] + place * self._at["size"]
            yield self._decode(self._chip.read_memory(at, self._at["size"]))
            self._n_read = (self._n_read + 1) & 0xFFFFFFFF

    def _decode(self, raw: bytes) -> Record:
        return {
            name: int.from_bytes(raw[at : at + 4], "little", signed=name in SIGNED)
            for name, at in self._fields
        }
