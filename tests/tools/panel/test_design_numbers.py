"""The numbers of a preview are those of the table, of the controller, and of its set-points."""

import json
import os
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.cache import Memory
from camtools.cut.feasibility import tenth_below
from camtools.panel.design.preview_worker import N_ANGLES, motion_of
from camtools.pipeline.kind import ExactTurn, SpeedRatio
from camtools.pipeline.load import make, parse
from tests.tools.cases.camsim_cases import cut
from tests.tools.cases.cut_cases import evaluated, made_of
from tests.tools.cases.preview_cases import PARTS, answers, problems, stage, text_of

CHAIN = ("u_um", "velocity_mm_s", "acceleration_m_s2", "jerk_km_s3")
KINDS = ("perkins240", "camshaft", "p4c-35", "thrust90", "cam-345")
TableOf = Callable[[str], Path]


@pytest.mark.parametrize("name", KINDS)
def test_size_is_that_of_the_file(name: str, table_of: TableOf) -> None:
    """Bytes, slices and knots are those of the image that mktables writes, and of its summary."""
    told = stage(answers(text_of(name)), "table")["table"]
    image = table_of(name).read_bytes()
    summary = json.loads(table_of(name).with_suffix(".json").read_bytes())
    assert told["bytes"] == len(image) == summary["table_bytes"]
    u = summary["channels"]["u"]
    shown = told["channels"][0]
    keys = ("bytes", "n_slices", "knots_per_pattern", "patterns_per_turn")
    assert [shown[key] for key in keys] == [u[key] for key in keys]


@pytest.mark.parametrize("name", ["perkins240", "p4c-35"])
def test_limits_and_highest_speed_are_the_controllers(name: str, table_of: TableOf) -> None:
    """What camsim's controller needs of each limit, and the highest speed that it takes."""
    told = stage(answers(text_of(name)), "table")
    loaded = parse(text_of(name).encode(), f"{name}.toml", PARTS)
    words = ("--turns-limit", "1", "--no-learning", "--tolerance-um", "99")
    found = cut(table_of(name), *words, machine=loaded.kind.machine(loaded.part))
    theirs = found.summary["feasibility"]
    # 0.1 r/min: the search in the simulator ends there
    assert told["highest_rpm"] == pytest.approx(theirs["highest_rpm"], abs=0.1)
    ours = {one["field"]: one for one in told["margins"] if one["name"].startswith("u_")}
    for field in ("u_speed_mm_s", "u_acceleration_mm_s2"):
        assert ours[field]["limit"] == theirs[field]["limit"]
        # the controller rounds what it needs up, and counts engaging, 0.3 % here
        assert ours[field]["needed"] == pytest.approx(theirs[field]["needed"], rel=4e-3)


@pytest.mark.parametrize(
    ("name", "z_mm"), [("perkins240", 47.0), ("thrust90", 20.0), ("camshaft", 11.0)]
)
def test_motion_is_the_difference_of_set_points(name: str, z_mm: float, tmp_path: Path) -> None:
    """Velocity, acceleration and jerk are the finite differences of what camsim eval tells of U."""
    shown = stage(answers(text_of(name), height_mm=z_mm), "curves")
    assert shown["height_mm"] == z_mm
    turn = np.arange(N_ANGLES) / N_ANGLES
    table = made_of(name).table.table
    u_um = evaluated(tmp_path, table, turn, np.full(N_ANGLES, z_mm))["u_nm"] * 1e-3
    if name == "camshaft":
        u_um = -u_um  # eval tells the lift, away from the axis
    motion = {key: np.array(values) for key, values in shown["motion"].items()}
    assert np.abs(motion["u_um"] - u_um).max() < 0.011  # the tables are within 10 nm
    step_s = 60 / shown["rpm"] / N_ANGLES
    for below, above in pairwise(CHAIN):
        values = u_um if below == "u_um" else motion[below]
        slope = (np.roll(values, -1) - np.roll(values, 1)) / (2 * step_s) * 1e-3
        # where a law of lift has a corner a difference over two steps rounds it off
        off = np.abs(slope - motion[above])
        assert np.quantile(off, 0.95) < 3e-3 * np.abs(motion[above]).max(), above


def test_a_modulated_spindle_moves_u_as_the_chain_rule_says() -> None:
    """Over the time itself, as the angle is integrated from the speed, the derivatives agree."""
    phi = 2 * np.pi * np.arange(4096) / 4096
    ratio = 1 + 0.2 * np.sin(2 * phi)
    law = SpeedRatio(ratio, 0.4 * np.cos(2 * phi), -0.8 * np.sin(2 * phi))
    u = (0.1 * (1 - np.cos(2 * phi)), 0.2 * np.sin(2 * phi), 0.4 * np.cos(2 * phi))
    turn = ExactTurn(phi, 46 + 0 * phi, 46.0, *u, -0.8 * np.sin(2 * phi))
    motion = motion_of(turn, 600.0, law)
    omega = 600 * 2 * np.pi / 60
    for below, above in pairwise(CHAIN):
        by_angle = np.gradient(motion[below], phi)[2:-2]
        by_time = by_angle * (ratio * omega)[2:-2] * 1e-3
        wanted = motion[above][2:-2]
        assert np.abs(by_time - wanted).max() < 1e-4 * np.abs(wanted).max()


def test_an_infeasible_part_keeps_its_numbers() -> None:
    """What is too fast is refused with the generator's own line, and the table is known still."""
    text = text_of("perkins240").replace("u_speed_mm_s = 400", "u_speed_mm_s = 20")
    found = answers(text)
    told = stage(found, "table")
    assert not told["is_feasible"]
    assert told["table"]["bytes"] == 3456
    speed = next(one for one in told["margins"] if one["name"] == "u_speed")
    assert speed["left_percent"] < 0
    [line] = problems(found)
    with pytest.raises(Exception, match="u_speed_mm_s") as refused:
        make(parse(text.encode(), "part.toml", PARTS), "part.toml")
    assert str(refused.value) == f"part.toml: {line}"
    assert f"{tenth_below(told['highest_rpm'])} r/min" in line
    assert told["problems"][0]["line"] == text.splitlines().index("u_speed_mm_s = 20") + 1


def test_what_is_remembered_changes_no_number() -> None:
    """A preview with a memory that saw other changes is that of a memory that saw none."""
    memory = Memory(64)
    text = text_of("perkins240")
    other = text.replace("spindle_rpm = 2500", "spindle_rpm = 900").replace("0.15,", "0.16,")
    last: list[dict[str, Any]] = []
    for one in (text, other, text):
        last = answers(one, memory=memory)
    assert last == answers(text)


def test_a_file_beside_the_part_that_changes_is_read_anew(tmp_path: Path) -> None:
    """The same text shows another section when its points are other ones."""
    csv = (PARTS / "scan90.csv").read_text()
    (tmp_path / "scan90.csv").write_text(csv)
    memory = Memory(64)
    before = stage(answers(text_of("scan90"), tmp_path, memory=memory), "curves")
    head, *rows = (row.split(",") for row in csv.splitlines())
    doubled = [[*row[:2], str(2 * float(row[2]))] for row in rows]
    lines = [",".join(row) + "\n" for row in [head, *doubled]]
    (tmp_path / "scan90.csv").write_text("".join(lines))
    os.utime(tmp_path / "scan90.csv", (1, 1))
    behind = stage(answers(text_of("scan90"), tmp_path, memory=memory), "curves")
    assert behind["stroke_um"] == pytest.approx(2 * before["stroke_um"], rel=1e-3)
