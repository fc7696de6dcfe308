# SPDX-License-Identifier: Apache-2.0
"""The files that the command lines of commands.txt name, good and bad ones.

A name in a command line is looked up here and the file is made in the folder in which the command
runs. Part files are changed copies of those in tools/parts.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

LAW = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70'
OVAL = "[piston.ovality]              # diametral: long minus short axis\nheight_mm = [0, 20, 62]"

Change = tuple[str, str]

# Changed copies of part files: the part that is copied, what is replaced by what.
PARTS: dict[str, tuple[str, list[Change]]] = {
    "misspelt.toml": (
        "perkins240",
        [
            ("height_mm = [0, 10", "hieght_mm = [0, 10"),
            ("shape =", "shpae ="),
            ("feed_mm", "fed_mm"),
            ("[machine.limits]", "[machine.limit]"),
            ("[part]", "[extra]\na = 1\n[part]"),
        ],
    ),
    "types.toml": (
        "perkins240",
        [
            ('name = "perkins240"', "name = 7"),
            ("height_mm = [0, 20, 62]", "height_mm = 5"),
            ("91.940,", '"92",'),
            ("92.0,", "true,"),
            ('shape = "ellipse"', "shape = 1"),
            ("spindle_rpm = 2500", 'spindle_rpm = "fast"'),
            ("direction = 1", "direction = true"),
            ("u_stroke_mm = 1.2", "u_stroke_mm = [1.2]"),
        ],
    ),
    "ranges.toml": (
        "perkins240",
        [
            ("91.940,", "4001,"),
            ("0.20, 0.30", "-0.20, 0.30"),
            ("[0.0029818594", "[200"),
            ("spindle_rpm = 2500", "spindle_rpm = 0"),
            ("feed_mm = 0.1 ", "feed_mm = 0 "),
            ("depth_mm = 0.1", "depth_mm = -0.1"),
            ("direction = 1", "direction = 0"),
            ("form_error_um = 0.2", "form_error_um = 0"),
            ("= 1.2", "= 0"),
            ("= 400", "= -1"),
        ],
    ),
    "infinite.toml": (
        "perkins240",
        [("91.940,", "nan,"), ("91.737]", "inf]"), ("feed_mm = 0.1 ", "feed_mm = nan ")],
    ),
    "missing.toml": (
        "perkins240",
        [('source = "', "#"), ("diameter_mm =", "#"), ("spindle_rpm = 2500", ""), ("shape =", "#")],
    ),
    "words.toml": (
        "perkins240",
        [
            ('name = "perkins240"', 'name = "../up"'),
            ('"clamped"', '"cubic"'),
            ('"linear"', '"none"'),
            ('"ellipse"', '"round"'),
            ("[process]", '[process]\nmode = "even"\nparts = 1'),
        ],
    ),
    "cross.toml": (
        "perkins240",
        [
            ('name = "perkins240"', 'name = "a\\nb"'),
            ('"clamped"', '"natural"'),
            (OVAL, OVAL.replace("62]", "61]")),
            ('"ellipse"', '"ellipse"\nbeta = 1'),
            ("[machine.limits]", "[machine.limits]\nspindle_torque_nm = 5"),
        ],
    ),
    "gear.toml": ("perkins240", [('kind = "piston"', 'kind = "gear"')]),
    "falling.toml": (
        "perkins240",
        [
            ("[0, 10, 20, 30, 40, 50, 62]", "[62, 50, 40, 30, 20, 10, 0]"),
            ("[process]", "[magnify]\nfaktor = 0.5\n[process]"),
        ],
    ),
    "fewer.toml": (
        "perkins240",
        [("[0, 10, 20, 30, 40, 50, 62]", "[0, 10]"), ('"ellipse"', '"ellipse-arc"')],
    ),
    "no-csv.toml": ("perkins240", [('"ellipse"', '"table"')]),
    "slow-u.toml": ("perkins240", [("= 400", "= 10")]),
    "short-u.toml": ("perkins240", [("= 1.2", "= 0.1")]),
    "weak-u.toml": ("perkins240", [("250000", "1000")]),
    "fast.toml": ("perkins240", [("= 2500", "= 3001")]),
    "coarse.toml": (
        "perkins240",
        [("[0, 10, 20, 30, 40, 50, 62]", "[0, 1, 2, 3, 4, 6, 8]"), ("= 0.1 ", "= 8.000001 ")],
    ),
    "inside-out.toml": ("perkins240", [("[process]", "[magnify]\nfactor = 1000\n[process]")]),
    "rings-fast.toml": (
        "perkins240",
        [("[process]", '[process]\npath = "ring-helix"'), ("feed_mm = 0.1 ", "feed_mm = 1 ")],
    ),
    "no-depth.toml": ("perkins240", [("depth_mm = 0.1", "depth_mm = 0")]),
    "no-refit.toml": (
        "weichai3a",
        [
            ("[piston.section.refit]", "[magnify]\nfactor = 1"),
            ('spline = "quintic"', ""),
            ('delete = "optimise"', ""),
            ('ends = "mirror"', ""),
        ],
    ),
    "refit.toml": ("weichai3a", [('"optimise"', "[3, 9]"), ('"mirror"', '"free"')]),
    "scan.toml": ("scan90", [("scan90.csv", "scan.csv")]),
    "scan-none.toml": ("scan90", [("scan90.csv", "none.csv")]),
    "cam-misspelt.toml": ("cam-345-ground", [("lift_mm", "lft_mm"), ("[cam]", "[cam]\na = 1")]),
    "cam-types.toml": (
        "cam-345-ground",
        [("lift_mm = 8", 'lift_mm = "8"'), ("[0, 12]", "[0]"), ("= 20\n", "= true\n")],
    ),
    "cam-ranges.toml": (
        "cam-345-ground",
        [
            ("= 8\n", "= 16\n"),
            ("[0, 12]", "[12, 0]"),
            ("roller_radius_mm = 10", "roller_radius_mm = 0"),
            ("half_angle_deg = 70", "half_angle_deg = 400\nphase_deg = 400"),
        ],
    ),
    "cam-words.toml": (
        "cam-345-ground",
        [('"poly345"', '"sine"'), ('"grinding"', '"milling"'), ('"constant-surface"', '"even"')],
    ),
    "cam-list.toml": (
        "cam-345-ground",
        [(LAW, 'law = "list"\nangle_deg = [0, 90]\nlift_mm = [1]')],
    ),
    "cam-no-wheel.toml": ("cam-345-ground", [("wheel_radius_mm = 200", "")]),
    "cam-hollow.toml": ("cam-345-ground", [("lift_mm = 8", "lift_mm = 12")]),
    "cam-close.toml": (
        "cam-345-ground",
        [("[process]", f"[[cam.lobe]]\nz_mm = [12.1, 20]\n{LAW}\n[process]")],
    ),
    "cam-weak.toml": ("cam-345-ground", [("= 20000", "= 1000")]),
}

TEXTS: dict[str, bytes] = {
    "empty.toml": b"",
    "hello.toml": b"hello\n",
    "nul.toml": b"a = '\x00'\n",
    "binary.toml": b"\xff\x00",
    "deep.toml": b"a = " + b"[" * 100_000,
    "huge.toml": b"#" * 1_000_001,
    "older": b"older, not a folder\n",
    "scan.csv": b"angle_deg,z_mm,reduction_um\n0,0,1\n10,0,nan\n",
    "long.machine": b'[machine]\nname = "long stroke"\n[u]\nstroke_mm = 12\n',
    "misspelt.machine": b"[u]\nsped_mm_per_s = 400\n",
    "section.machine": b"[v]\nspeed_mm_per_s = 400\n",
    "word.machine": b"[u]\nspeed_mm_per_s = fast\n",
    "range.machine": b"[u]\nspeed_mm_per_s = -1\n",
    "half.machine": b"[encoder]\ncounts_per_turn = 10000.5\n",
    "twice.machine": b"[u]\nspeed_mm_per_s = 1\nspeed_mm_per_s = 2\n",
    "nul.machine": b"[u]\n\x00\n",
    "bare.machine": b"speed_mm_per_s\n",
    "parameter.machine": b"[controller]\nk9_ns = 1\n",
    "points.csv": b"turn,z_mm\n0,20\n0.125,20\n-0.9,30\n1.25,62\n0,62.001\n",
    "lobe.csv": b"turn,z_mm\n0,6\n0.1,6\n0.5,6\n0.95,6\n",
    "header.csv": b"z_mm,turn\n0,1\n",
    "two.csv": b"turn,z_mm\n0,20\n0.1\n",
    "three.csv": b"turn,z_mm\n0,20,7\n",
    "letters.csv": b"turn,z_mm\nabc,20\n",
    "nan.csv": b"turn,z_mm\n0,nan\n",
    "no-points.csv": b"",
    "text.camtab": b"this is not a table\n" * 50,
    "empty.camtab": b"",
}

FAKE = '#!/bin/sh\nprintf "%s\\n" "{name}" "$@"\nexit {status}\n'
PROGRAMMERS = {"openocd": 0, "st-flash": 0, "pyocd": 3}


@cache
def listed() -> list[Path]:
    """Return all files of the repository, as git knows them and as they lie here."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return [path for line in done.stdout.splitlines() if (path := ROOT / line).is_file()]


def found(name: str) -> Path:
    """Return the one file of the repository with a name; files may move."""
    (path,) = (path for path in listed() if path.name == name)
    return path


@cache
def parts() -> dict[str, Path]:
    """Return all part files of the repository by their names without an ending."""
    files = (path for path in listed() if path.parts[-3:-1] == ("tools", "parts"))
    return {path.stem: path for path in sorted(files) if path.suffix == ".toml"}


def changed(part: str, changes: list[Change]) -> bytes:
    """Return the bytes of a part file with texts replaced."""
    text = found(f"{part}.toml").read_text()
    for old, new in changes:
        assert old in text, (part, old)
        text = text.replace(old, new, 1)
    return text.encode()


def spoilt(image: bytes) -> dict[str, bytes]:
    """Return tables with something wrong."""
    flipped = bytearray(image)
    flipped[len(image) // 2] ^= 0x10
    return {
        "short.camtab": image[:100],
        "cut.camtab": image[:-32],
        "longer.camtab": image + bytes(32),
        "flipped.camtab": bytes(flipped),
        "order.camtab": image[:8] + image[11:7:-1] + image[12:],
        "version.camtab": image[:12] + b"\x02" + image[13:],
        "lonely.camtab": image,
    }


def spoilt_designs(report: str) -> dict[str, bytes]:
    """Return reports of mktables with something wrong in the design."""

    def with_design(**values: object) -> bytes:
        one = json.loads(report)
        one["design"].update(values)
        return json.dumps(one).encode()

    other = json.loads(report)
    other["table_crc32"] ^= 1
    return {
        "other.json": json.dumps(other).encode(),
        "text.json": b"no report\n",
        "list.json": b"[]\n",
        "shape.json": with_design(shape="square"),
        "breaks.json": with_design(radius_mm={"breaks_mm": [1, 0], "coefficients": []}),
    }


def _write_special(name: str, path: Path) -> bool:
    """Make what is no plain file; return whether the name was one of those."""
    if name == "folder":
        path.mkdir()
    elif name == "pipe":
        os.mkfifo(path)
    elif name == "fakes":
        path.mkdir()
        for program, status in PROGRAMMERS.items():
            (path / program).write_text(FAKE.format(name=program, status=status))
            (path / program).chmod(0o755)
    else:
        return False
    return True


def content(name: str, table: Callable[[str], Path]) -> bytes | None:
    """Return the bytes of a named file, nothing when it is none of ours."""
    if name in TEXTS:
        return TEXTS[name]
    if name in PARTS:
        return changed(*PARTS[name])
    stem, _, ending = name.rpartition(".")
    if ending == "camtab" and stem in parts():
        return table(stem).read_bytes()
    if ending == "camtab":
        return spoilt(table("perkins240").read_bytes()).get(name)
    if ending == "json":
        report = table("perkins240").with_suffix(".json")
        return spoilt_designs(report.read_text()).get(name)
    if ending == "machine":
        return found(f"{stem}.toml").read_bytes()
    return parts()[stem].read_bytes() if ending == "toml" and stem in parts() else None


def make(name: str, folder: Path, table: Callable[[str], Path]) -> None:
    """Make a named file in a folder, and what belongs beside it; other names make nothing."""
    path = folder / name
    if path.exists() or _write_special(name, path):
        return
    data = content(name, table)
    if data is None:
        return
    path.write_bytes(data)
    stem = name.removesuffix(".camtab")
    if stem in parts():
        path.with_suffix(".json").write_bytes(table(stem).with_suffix(".json").read_bytes())
    if name == "scan90.toml":
        (folder / "scan90.csv").write_bytes(found("scan90.csv").read_bytes())
    if name == "scan.toml":
        make("scan.csv", folder, table)
