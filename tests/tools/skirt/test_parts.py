# SPDX-License-Identifier: Apache-2.0
"""Every part of the repository, from its drawing to the gauged cut."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.quantities import omega_rad_s
from camtools.cut.speed_law import uniform
from camtools.pipeline.load import load
from camtools.pipeline.make_table import Made
from camtools.sim.camsim import machine_text
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.table.channel import KIND_U
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import camsim, columns_of
from tests.tools.cases.part_cases import ROOT, load_part, parse_part

ALL_PARTS = sorted((ROOT / "tools" / "parts").glob("*.toml"))
PARTS = [
    path for path in ALL_PARTS if isinstance(load(path).part, SkirtPart)
]  # camshafts: tests/tools/lobe/test_camsim.py
EQUAL_VOLUME = ROOT / "tools" / "parts" / "perkins240_equal_volume.toml"
MAX_TABLE_BYTES = 512 * 1024


def cut(result: GeneratedSkirt, folder: Path, *words: str | Path) -> dict[str, Any]:
    """Cut a part on the simulator with its machine's limits; return the summary."""
    name = result.part.part.name
    for file, data in Made(KIND, result).files(with_plots=False).items():
        (folder / file).write_bytes(data)
    (folder / "machine.toml").write_text(machine_text(result.part.machine.limits))
    tolerance = repr(result.part.process.form_error_um)
    options: list[str | Path] = ["--machine", folder / "machine.toml", "--tolerance-um", tolerance]
    done = camsim(
        "run", folder / f"{name}.camtab", *options, "--summary", folder / "s.json", *words
    )
    assert done.returncode == 0, done.stderr
    summary: dict[str, Any] = json.loads((folder / "s.json").read_text())
    return summary


@pytest.mark.parametrize("path", PARTS, ids=lambda path: path.stem)
def test_part_is_cut_within_its_stated_form_error(path: Path, tmp_path: Path) -> None:
    """The table keeps its tolerance and size, the cut the form error that the part states."""
    part = load_part(path)
    result = generate(part)
    tolerance_nm = 1.0 if result.geometry.corner is None else 5.0
    assert result.accuracy_u.value_nm <= tolerance_nm
    assert result.accuracy_x.value_nm <= 1.0
    assert len(pack(result.table)) <= MAX_TABLE_BYTES
    summary = cut(result, tmp_path)
    assert summary["gauge"]["reference"] == "design"
    assert summary["faults"] == []
    assert summary["form_error_um"]["max"] <= part.process.form_error_um
    assert summary["cut"]["turns"] == pytest.approx(summary["cut"]["planned_turns"], abs=0.1)


def test_equal_volume_evens_the_removal_rate(modulated: GeneratedSkirt, tmp_path: Path) -> None:
    """Rate and power become even on the workpiece, the chip force does not; no form is lost."""
    text = EQUAL_VOLUME.read_text().replace('mode = "equal-volume"', 'mode = "uniform"')
    plain = generate(parse_part(text.encode(), "uniform.toml"))
    assert plain.speed is None
    even, rough = cut(modulated, tmp_path), cut(plain, tmp_path)
    assert modulated.speed is not None
    ripple = even["removal"]["rate_ripple"]["max"]
    assert ripple == pytest.approx(modulated.speed.played.max(), abs=0.01)
    assert rough["removal"]["rate_ripple"]["max"] > 0.6
    forces = (one["removal"]["chip_force_ripple"]["mean"] for one in (even, rough))
    assert next(forces) == pytest.approx(next(forces), rel=0.05)
    volumes = (one["removal"]["volume_mm3"] for one in (even, rough))
    assert next(volumes) == pytest.approx(next(volumes), rel=1e-3)
    # the encoder's half count shows where its edges come in step with the ticks, here at 240 r/min,
    # which the modulated spindle passes in every turn: the bound is that of uniform turning there
    in_step = cut(plain, tmp_path, "--rpm", "240")
    assert even["form_error_um"]["max"] <= in_step["form_error_um"]["max"] < 0.1
    assert even["cut"]["seconds"] == pytest.approx(rough["cut"]["seconds"], rel=2e-3)


def test_spindle_stays_within_its_acceleration(modulated: GeneratedSkirt, tmp_path: Path) -> None:
    """The set-points of the trace, seen as a speed, never exceed what the spindle can do."""
    cut(modulated, tmp_path, "--turns-limit", "8", "--trace", str(tmp_path / "t.csv"))
    trace = columns_of(tmp_path / "t.csv")
    turn, t_s = (trace[name][trace["state"] == "cutting"] for name in ("true_turn", "t_s"))
    step = 40  # 2 ms: the encoder's truth is smooth, the kinematic ripple of 0.2 % is not counted
    speed = 2 * np.pi * (turn[step:] - turn[:-step]) / (t_s[step:] - t_s[:-step])
    alpha = (speed[step:] - speed[:-step]) / (t_s[step:-step] - t_s[: -2 * step])
    limit = modulated.part.machine.limits.alpha_rad_s2
    mean = omega_rad_s(230)
    ripple = 0.002 * 2 * mean**2 * 1.51**2  # of the simulated spindle's own
    assert modulated.speed is not None
    low, high = (law.peaks[0] * mean**2 for law in modulated.speed.laws[:2])  # at 0 and 3.9 mm
    assert low - ripple < float(np.abs(alpha).max()) < high + ripple < limit


def test_eval_gives_the_speed_ratio(modulated: GeneratedSkirt, tmp_path: Path) -> None:
    """The firmware's own ratio is the law's, at the slices and in the sense of cutting."""
    assert modulated.speed is not None
    for file, data in Made(KIND, modulated).files(with_plots=False).items():
        (tmp_path / file).write_bytes(data)
    turn, z_mm = np.linspace(-1, 2, 61), float(modulated.speed.z_mm[4])
    points = "turn,z_mm\n" + "".join(f"{one:.9f},{z_mm:.9f}\n" for one in turn)
    done = camsim("eval", tmp_path / "perkins240_equal_volume.camtab", stdin=points)
    assert done.returncode == 0
    found = [float(row["speed_ratio"]) for row in csv.DictReader(done.stdout.splitlines())]
    law = modulated.speed.laws[4]
    np.testing.assert_allclose(found, law.ratio(2 * np.pi * turn), atol=2e-6)
    times = 1 / law.ratio(np.linspace(0, np.pi, 20_000, endpoint=False))
    assert float(times.mean()) == pytest.approx(1.0, abs=1e-9)


def test_laws_beat_partial_modulation_at_every_height(modulated: GeneratedSkirt) -> None:
    """Uniform is worst, partial better, the optimised law best; the table grows by its channel."""
    assert modulated.speed is not None
    for law, blended in zip(modulated.speed.laws, modulated.speed.partial, strict=True):
        assert law.ripple <= blended.ripple < 0.2 < uniform(law.load).ripple
    worst = [
        max(law.ripple for law in laws) for laws in (modulated.speed.laws, modulated.speed.partial)
    ]
    assert worst[0] < 0.5 * worst[1]
    assert modulated.table.speed is not None
    assert modulated.table.channel(KIND_U).size < modulated.table.speed.size
