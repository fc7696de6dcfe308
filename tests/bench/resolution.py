r"""What each resolution of a machine costs of form, cut by cut on the simulator, beside its bound.

Each row of the first table spoils one thing of a machine that is else exact; the bounds
are MATHS.md (183) .. (187). The second table cuts with the scales of a whole port. Both stand in
documents, behind comments, and test_resolution.py compares them.

>>> markdown(("step", "um"), [("100 nm", "0.05")])
'| step | um |\n|---|---|\n| 100 nm | 0.05 |\n'
>>> toml({"u.quantum_nm": 0, "believed.u.bandwidth_hz": 270})
'[u]\nquantum_nm = 0\n[believed.u]\nbandwidth_hz = 270\n'
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
CAMSIM = ROOT / os.environ.get("CAMTURN_BUILD", "build/host") / "host_sim" / "camsim"
PART = ROOT / "tools" / "parts" / "perkins240.toml"
RPM = 2500

Keys = Mapping[str, float]
EXACT: Keys = {
    "spindle.ripple": 0,
    "encoder.counts_per_turn": 2**24,
    "encoder.index_turn": 0.25,  # between two counts of every encoder below
    "u.quantum_nm": 0,
    "x.quantum_nm": 0,
    "z.quantum_nm": 0,
}
FINE_NM = 0.001  # 0 would mean the quantum of the measurement


@dataclass(frozen=True)
class Shape:
    """Largest derivatives of a part: of U by the angle, of its radius by the height."""

    u1_um_per_rad: float
    u2_um_per_rad2: float
    slope: float


@dataclass(frozen=True)
class Row:
    """A machine that is spoilt in one way.

    Attributes
    ----------
    keys : mapping
        of its machine file, beside EXACT
    bound_um : callable
        of the form error, by shape and speed of the spindle in rad/s; None: there is none
    """

    what: str
    value: str
    keys: Keys
    bound_um: Callable[[Shape, float], float] | None = None
    rpm: int = RPM
    settings: tuple[str, ...] = ("--no-learning",)


def _step(axis: str, step_nm: float, why: str) -> Row:
    """Return a row whose set-points of an axis come in steps, (183)."""
    return Row(
        f"step of {axis.upper()}",
        f"{step_nm:g} nm: {why}",
        {f"{axis}.command_quantum_nm": step_nm},
        lambda shape, _: step_nm / 2000 * (shape.slope if axis == "z" else 1),
    )


def _scale(step_nm: float) -> Row:
    """Return a row whose U is believed 10 % too slow; what its scale cannot show stays, (184)."""
    keys = {
        "u.quantum_nm": step_nm,
        "u.command_quantum_nm": FINE_NM,
        "believed.u.bandwidth_hz": 270,
    }
    return Row(
        "scale of U, that learns", f"{step_nm:g} nm", keys, lambda *_: step_nm / 2000, settings=()
    )


def _encoder(counts: int, rpm: int, *, is_stamped: bool = False) -> Row:
    """Return a row with a coarse encoder, (185)."""
    keys = {"encoder.counts_per_turn": counts, "encoder.time_stamps": int(is_stamped)}
    value = f"{counts} counts, {rpm} r/min" + (", edges stamped" if is_stamped else "")
    return Row("encoder", value, keys, lambda s, _: s.u1_um_per_rad * pi / counts, rpm)


def _tick(hz: int) -> Row:
    """Return a row with another tick, (186)."""
    return Row(
        "tick",
        f"{hz} Hz",
        {"machine.tick_hz": hz},
        lambda shape, omega: shape.u2_um_per_rad2 * (omega / hz) ** 2 / 48,
    )


def _delay(late_us: float) -> Row:
    """Return a row whose U is later than lead_ns says, (187)."""
    return Row(
        "delay not in lead_ns",
        f"{late_us:g} us",
        {},
        lambda shape, omega: shape.u1_um_per_rad * omega * late_us * 1e-6,
        settings=("--no-learning", "--set", f"lead_ns={100_000 + round(late_us * 1000)}"),
    )


ROWS = (
    Row("nothing", "tick of 20 kHz", {}),
    _step("u", 30.5, "16 bits for +-1 mm"),
    _step("u", 488, "12 bits for +-1 mm"),
    _step("x", 50, "step and direction"),
    _step("x", 6103.5, "16 bits for +-200 mm"),
    _step("z", 500, "step and direction"),
    _step("z", 15258.8, "16 bits for +-500 mm"),
    _scale(100),
    _scale(1000),
    _encoder(1024, 2500),
    _encoder(1024, 600),
    _encoder(1024, 600, is_stamped=True),
    _encoder(10_000, 600),
    _tick(10_000),
    _tick(5000),
    _tick(1000),
    _delay(1),
    _delay(10),
)

# Scales of whole ports. Drives on CAN have a screw of 5 mm and 17 bits a turn.
DEFAULT: Keys = {"encoder.index_turn": 0.25}
STM32 = {
    "encoder.time_stamps": 1,
    "u.quantum_nm": 100,
    "u.command_quantum_nm": 30.5,
    "x.command_quantum_nm": 50,
    "z.command_quantum_nm": 500,
}
VOLTS = STM32 | {"x.command_quantum_nm": 6103.5, "z.command_quantum_nm": 15258.8}
CAN = {f"{axis}.quantum_nm": 38.1 for axis in "uxz"} | {"machine.tick_hz": 1000}
PORTS: tuple[tuple[str, Keys], ...] = (
    ("STM32H743, 20 kHz, as shipped", STM32),
    ("the same, X and Z by voltage", VOLTS),
    ("LinuxCNC, servo thread of 5 kHz", {"machine.tick_hz": 5000}),
    ("LinuxCNC, servo thread of 1 kHz", {"machine.tick_hz": 1000}),
    ("Linux with CAN FD, 1 kHz", CAN),
    ("Linux with classic CAN, 500 Hz", CAN | {"machine.tick_hz": 500}),
)
SPEEDS = (100, 300, 1000, 2500)


def toml(keys: Keys) -> str:
    """Return a machine file of keys `section.name`."""
    sections: dict[str, str] = {}
    for key, value in keys.items():
        section, name = key.rsplit(".", 1)
        sections[section] = sections.get(section, f"[{section}]\n") + f"{name} = {value}\n"
    return "".join(sections.values())


def make_table(folder: Path) -> Path:
    """Make the part's table in a folder; return its path."""
    command = [sys.executable, "-m", "camtools.cli.mktables", str(PART), "-o", str(folder)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / f"{PART.stem}.camtab"


def cut_um(table: Path, keys: Keys, rpm: int, settings: Sequence[str] = ()) -> float:
    """Return the largest form error of a cut."""
    machine, summary = table.with_name("machine.toml"), table.with_name("summary.json")
    machine.write_text(toml(keys))
    options = ["--rpm", str(rpm), "--summary", str(summary), *settings]
    command = [str(CAMSIM), "run", str(table), "--machine", str(machine), *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):  # 1: out of the tolerance of a good part
        raise RuntimeError(done.stderr)
    return float(json.loads(summary.read_text())["form_error_um"]["max"])


def cut_row_um(table: Path, row: Row) -> float:
    """Return the largest form error of a row."""
    return cut_um(table, {**EXACT, **row.keys}, row.rpm, row.settings)


def shape_of(table: Path) -> Shape:
    """Return what the bounds need: the table's guarantees, and slopes sampled every 0.1 mm."""
    report = json.loads(table.with_suffix(".json").read_text())
    low_mm, high_mm = report["height_range_mm"]
    n = int((high_mm - low_mm) / 0.1)
    points = [(turn, low_mm + 0.1 * i) for turn in (0.0, 0.25) for i in range(n)]
    text = "turn,z_mm\n" + "".join(f"{turn},{z_mm}\n" for turn, z_mm in points)
    command = [str(CAMSIM), "eval", str(table)]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    values = [[float(word) for word in line.split(",")] for line in done.stdout.split()[1:]]
    radius_nm = [row[5] - row[2] for row in values]
    sides = (radius_nm[:n], radius_nm[n:])
    slope = max(abs(b - a) for side in sides for a, b in pairwise(side)) / 1e5
    most = report["guaranteed"]
    return Shape(most["u1_peak_nm_per_rad"] / 1e3, most["u2_peak_nm_per_rad2"] / 1e3, slope)


def bound_um(row: Row, shape: Shape) -> float | None:
    """Return the bound of a row alone, without what the exact machine leaves."""
    return None if row.bound_um is None else row.bound_um(shape, row.rpm * 2 * pi / 60)


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table."""
    lines = [" | ".join(head), *(" | ".join(row) for row in rows)]
    first, *rest = (f"| {line} |\n" for line in lines)
    return "".join([first, "|" + "---|" * len(head) + "\n", *rest])


def resolution_table(table: Path) -> str:
    """Return the first table."""
    shape = shape_of(table)
    rows = []
    for row in ROWS:
        bound = bound_um(row, shape)
        found = f"{cut_row_um(table, row):.3f}"
        rows.append((row.what, row.value, found, "-" if bound is None else f"{bound:.3f}"))
    return markdown(("coarse is", "by", "form error, um", "its equation, um"), rows)


def ports_table(table: Path) -> str:
    """Return the second table."""
    rows = [
        (name, *(f"{cut_um(table, {**DEFAULT, **keys}, rpm):.2f}" for rpm in SPEEDS))
        for name, keys in PORTS
    ]
    return markdown(("form error in um at r/min", *map(str, SPEEDS)), rows)


TABLES = {
    "resolution": (ROOT / "hal" / "RETROFIT.md", resolution_table),
    "ports": (ROOT / "hal" / "RETROFIT.md", ports_table),
}


def recorded(name: str) -> tuple[str, str, str]:
    """Return a document before its table, the table, and the rest."""
    text = TABLES[name][0].read_text()
    before, mark, rest = text.partition(f"<!-- {name}: tests/bench/resolution -->\n")
    table, blank, after = rest.partition("\n\n")
    return before + mark, table + "\n", blank[1:] + after


def main(words: list[str]) -> int:
    """Print the tables; with --record, write them into their documents."""
    with TemporaryDirectory() as folder:
        path = make_table(Path(folder))
        for name, (document, make) in TABLES.items():
            text = make(path)
            print(text)
            if words == ["--record"]:
                before, _, after = recorded(name)
                document.write_text(before + text + after)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
