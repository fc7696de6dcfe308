"""Measure the figures of FIGURES.md, record them in figures.json and write the page.

A case makes the table of a part, cuts it on the simulator and names some numbers of the table's
report and of the cut's summary. Simulator and generator are deterministic, so a case gives the same
numbers on every machine. The emulated cores write their counts themselves
(BUILD/PRESET/tests/budget/figures.json). figures.template is the text of the page, with
{KEY:DECIMALS} in place of each figure.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
RECORD = HERE / "figures.json"
TEMPLATE = HERE / "figures.template"
PAGE = HERE / "FIGURES.md"
BUILD = Path(os.environ.get("CAMTURN_BUILD", ROOT / "build" / "host")).parent
CORES = {"m7": "mcu-qemu", "m4": "mcu-qemu-m4"}
CORE_FIGURES = (
    "tick_cut_max",
    "tick_max",
    "plan_tick_max",
    "mean",
    "mean_uniform",
    "mean_modulated",
    "stack_bytes",
)

Figures = dict[str, float]
_PLACE = re.compile(r"\{([\w.]+):(\d)\}")
_TABLES = TemporaryDirectory()


@dataclass(frozen=True)
class Case:
    """A part, how it is cut, and the figures that are taken from it."""

    name: str
    part: str
    arguments: tuple[str, ...] = ()
    table: Mapping[str, str] = field(default_factory=dict)  # figure: place in NAME.json
    cut: Mapping[str, str] = field(default_factory=dict)  # figure: place in the summary


FORM = {"form_max_um": "form_error_um.max"}
FORM_RMS = {"form_rms_um": "form_error_um.rms"}
CAM_MACHINE = ("--machine", str(ROOT / "host_sim" / "machines" / "cam.toml"))
LOBES = {f"lobe_{i}_max_um": f"cam.lobes.{i}.max_um" for i in range(3)}
LOBE = {"max_um": "cam.lobes.0.max_um"}
LOBE_RMS = {"rms_um": "cam.lobes.0.rms_um"}
RIPPLE = {
    "ripple_max_percent": "removal.rate_ripple.max",
    "ripple_mean_percent": "removal.rate_ripple.mean",
}

CASES = (
    Case(
        "perkins240",
        "perkins240",
        table={"bytes": "table_bytes", "u_nm": "error.u.value_nm", "x_nm": "error.x.value_nm"},
        cut=FORM | FORM_RMS | RIPPLE,
    ),
    Case("no_lead", "perkins240", ("--no-learning", "--no-lead"), cut=FORM),
    Case("no_feed_forward", "perkins240", ("--no-learning", "--no-feed-forward"), cut=FORM),
    Case("neither", "perkins240", ("--no-learning", "--no-lead", "--no-feed-forward"), cut=FORM),
    Case("k1_wrong", "perkins240", ("--set", "k1_ns=780000"), cut=FORM),
    Case("rough", "perkins240", ("--machine", f"{ROOT}/host_sim/machines/rough.toml"), cut=FORM),
    Case("piezo", "perkins240", ("--machine", f"{ROOT}/host_sim/machines/piezo.toml"), cut=FORM),
    Case(
        "equal_volume",
        "perkins240_equal_volume",
        table={"planned_percent": "equal_volume.ripple"},
        cut=FORM | RIPPLE,
    ),
    Case(
        "16v240zj",
        "16v240zj",
        table={"bytes": "table_bytes", "u_nm": "error.u.value_nm"},
        cut=FORM | {"control_max_um": "control_error_um.max"},
    ),
    Case(
        "ring_helix",
        "perkins240_ring_helix",
        ("--nose-mm", "0.8"),
        cut=FORM | {"scallop_um": "scallop.peak_to_valley_max_um"},
    ),
    Case(
        "cam_turned",
        "cam-345",
        CAM_MACHINE,
        cut=LOBE
        | LOBE_RMS
        | {"rake_deg": "cam.rake_deg.max", "no_swing_deg": "cam.rake_deg.without_swing_max"},
    ),
    Case("cam_turned_120", "cam-345", (*CAM_MACHINE, "--rpm", "120"), cut=LOBE),
    Case(
        "cam_ground",
        "cam-345-ground",
        CAM_MACHINE,
        cut=LOBE | LOBE_RMS | {"contact_mm_per_s": "cam.surface_speed_mm_s.max"},
    ),
    Case("cam_disc", "cam-disc", CAM_MACHINE, cut=LOBE),
    Case("camshaft", "camshaft", CAM_MACHINE, cut=LOBES),
)


def _value(figure: str, tree: Any, place: str) -> float:  # noqa: ANN401 - JSON values
    for step in place.split("."):
        tree = tree[int(step)] if isinstance(tree, list) else tree[step]
    return float(tree) * (100.0 if figure.endswith("_percent") else 1.0)


def _run(*command: str | Path, most: int = 0) -> None:
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=ROOT)
    if not 0 <= done.returncode <= most:
        raise SystemExit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


@cache
def table_of(part: str) -> Path:
    """Return the table of a part, which is made once."""
    folder = Path(_TABLES.name) / part
    _run(ROOT / "tools" / "mktables", ROOT / "tools/parts" / f"{part}.toml", "-o", folder)
    return next(folder.glob("*.camtab"))


def measure(case: Case) -> Figures:
    """Return the figures of a case, by key.

    Raises
    ------
    SystemExit
        The table cannot be made, or the cut fails.
    """
    table = table_of(case.part)
    summary = table.with_name("summary.json")
    camsim = BUILD / "host" / "host_sim" / "camsim"
    _run(camsim, "run", table, *case.arguments, "--summary", summary, most=1)
    report = json.loads(table.with_suffix(".json").read_text())
    record = json.loads(summary.read_text())
    found = {k: _value(k, report, place) for k, place in case.table.items()}
    found |= {k: _value(k, record, place) for k, place in case.cut.items()}
    return {f"{case.name}.{figure}": value for figure, value in found.items()}


def core_figures(core: str) -> Figures:
    """Return what the budget tests of an emulated core wrote, by key.

    Raises
    ------
    FileNotFoundError
        They have not run.
    """
    record = json.loads((BUILD / CORES[core] / "tests" / "budget" / "figures.json").read_text())
    return {f"{core}.{figure}": float(record[figure]) for figure in CORE_FIGURES}


def recorded() -> Figures:
    """Return the record."""
    figures: Figures = json.loads(RECORD.read_text())
    return figures


def keep(figures: Figures) -> None:
    """Put figures into the record; those of other keys stay."""
    before = recorded() if RECORD.exists() else {}
    RECORD.write_text(json.dumps(before | figures, indent=1, sort_keys=True) + "\n")


def decimals(template: str) -> dict[str, int]:
    """Return how many decimals a template prints of each figure.

    >>> decimals("form error {a.form_um:3} um, {a.bytes:0} bytes")
    {'a.form_um': 3, 'a.bytes': 0}
    """
    return {key: int(count) for key, count in _PLACE.findall(template)}


def filled(template: str, figures: Figures) -> str:
    """Return a template with its figures, in groups of three digits.

    >>> filled("{a.form_um:3} um, {a.bytes:0} bytes", {"a.form_um": 0.08811, "a.bytes": 28512.0})
    '0.088 um, 28 512 bytes'
    """
    return _PLACE.sub(lambda m: f"{figures[m[1]]:,.{m[2]}f}".replace(",", " "), template)


def page() -> str:
    """Return FIGURES.md: the template with the recorded figures."""
    return filled(TEMPLATE.read_text(), recorded())


def main() -> int:
    """Measure every case, take the cores' own counts, record it all, and write FIGURES.md."""
    for case in CASES:
        figures = measure(case)
        for key, value in figures.items():
            print(f"{key:32} {value:.6g}")
        keep(figures)
    for core in CORES:
        try:
            keep(core_figures(core))
        except FileNotFoundError as error:
            print(f"not recorded: {error.filename} is not there; run ctest --preset {CORES[core]}")
    PAGE.write_text(page())
    return 0


if __name__ == "__main__":
    sys.exit(main())
