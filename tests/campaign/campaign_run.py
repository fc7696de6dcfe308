# SPDX-License-Identifier: Apache-2.0
"""Runs the parts of the campaign and adds their figures up."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from reactions import CASES, Reaction, react

from camtools.cli.mktables import main as mktables

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "campaign"
BUILT = ROOT / "build" / "host"
PROGRAMS = BUILT / "tests" / "campaign"
WORK = ROOT / "build" / "verify" / "campaign"
FIGURES = ROOT / "build" / "verify" / "campaign.json"
PART = "perkins240"
# Tick rate, its share of the hours, and what is added to the seed. 20 kHz are in two parts, one for
# each core.
HOURS = ((20000, 4, 3), (20000, 4, 4), (5000, 4, 2), (2000, 6, 1), (1000, 6, 0))
# Parts of the firmware whose own tests let the supply fall, without a program here.
KEPT_TESTS = ("test_stm_params",)

Figures = dict[str, float | int | str]


def object_of(program: Path, *words: str) -> tuple[list[dict[str, float | int | str]], str]:
    """Run a program that prints JSON objects. Return them, and what is wrong."""
    done = subprocess.run([program, *words], capture_output=True, text=True, check=False)
    found = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    last = (done.stdout + done.stderr).strip().splitlines()
    wrong = "" if done.returncode == 0 else f"{program.name} {' '.join(words)}: {last[-1:]}"
    if wrong and last:
        begun = [line for line in last if line.startswith("session")]
        wrong += "".join(f" ({line})" for line in begun[-1:])
    return found, wrong


def power() -> tuple[Figures, list[str]]:
    """Let the supply fall at every write."""
    flat: Figures = {}
    wrong: list[str] = []
    for name in ("power_stm", "power_linux"):
        found, why = object_of(PROGRAMS / f"campaign_{name}")
        wrong += [why] if why else []
        flat |= {f"{name}_{key}": value for row in found for key, value in row.items()}
    for name in KEPT_TESTS:
        _, why = object_of(BUILT / "tests" / "unit" / name)
        wrong += [why] if why else []
        flat[f"{name}_failed"] = int(bool(why))
    return flat, wrong


def bus() -> tuple[Figures, list[str]]:
    """Disturb the command bus."""
    found, why = object_of(PROGRAMS / "campaign_bus")
    flat: Figures = {}
    for row in found:
        name = row.pop("case")
        flat |= {f"bus_{name}_{key}": value for key, value in row.items()}
    return flat, [why] if why else []


def key_of(reaction: Reaction) -> str:
    """Return the begin of the keys of a reaction."""
    words = "".join(c if c.isalnum() else "_" for c in reaction.case.name.replace("-", "minus"))
    return "reaction_" + "_".join(word for word in words.split("_") if word)


def reactions(jobs: int) -> tuple[Figures, list[str]]:
    """Cut a part with every disturbance."""
    if mktables([str(ROOT / "tools" / "parts" / f"{PART}.toml"), "-o", str(WORK)]) != 0:
        return {}, ["no table"]
    camsim, table = BUILT / "host_sim" / "camsim", WORK / f"{PART}.camtab"
    flat: Figures = {}
    wrong: list[str] = []
    with ThreadPoolExecutor(jobs) as pool:
        for r in pool.map(lambda case: react(camsim, table, case, WORK), CASES):
            key = key_of(r)
            flat[f"{key}_name"] = r.case.name
            flat[f"{key}_fault"] = r.fault
            for what in ("form_um", "latch_ticks", "out_ms", "gouge_um"):
                value = getattr(r, what)
                if value is not None:
                    flat[f"{key}_{what}"] = value
            wrong += [f"{r.case.name}: {r.wrong}"] if r.wrong else []
    return flat, wrong


def hours(asked_h: float, seed: int, jobs: int) -> tuple[Figures, list[str]]:
    """Let an operator cut for hours of machine time, with bad luck at random."""
    whole = sum(share for _, share, _ in HOURS)

    def one(row: tuple[int, int, int]) -> tuple[int, list[Figures], str]:
        hz, share, offset = row
        words = (str(hz), f"{asked_h * share / whole:.6f}", str(seed * 10 + offset))
        return hz, *object_of(PROGRAMS / "campaign_hours", *words)

    flat: Figures = {}
    wrong: list[str] = []
    with ThreadPoolExecutor(jobs) as pool:
        for hz, found, why in pool.map(one, HOURS):
            wrong += [why] if why else []
            for row in found:
                for key, value in row.items():
                    assert not isinstance(value, str)
                    for name in (f"hours_{key}", f"hours_{key}_at_{hz}_hz"):
                        if name.startswith(("hours_ticks", "hours_hours")) or "_at_" not in name:
                            flat[name] = round(float(flat.get(name, 0)) + value, 3)
    flat |= {k: int(v) for k, v in flat.items() if not k.startswith("hours_hours")}
    return flat | {"hours_seed": seed}, wrong


def row(*cells: object) -> str:
    """Return a row of a table."""
    return "| " + " | ".join("" if cell is None else str(cell) for cell in cells) + " |"


def tables(flat: Figures) -> str:
    """Return the tables of README.md."""
    rows = [
        "### Reactions\n",
        row("disturbance", "fault", "latched after, ticks", "tip out of the work, ms",
            "below the drawing, um", "form error of the cut that goes on, um"),
        "|---|---|---:|---:|---:|---:|",
    ]  # fmt: skip
    for key, name in flat.items():
        if key.startswith("reaction_") and key.endswith("_name"):
            stem = key.removesuffix("_name")
            told = [
                flat.get(f"{stem}_{k}") for k in ("latch_ticks", "out_ms", "gouge_um", "form_um")
            ]
            fault = flat[f"{stem}_fault"]
            rows.append(row(name, f"`{fault}`" if fault else "none", *told))
    rows += ["\n### Command bus\n",
             row("bus", "set-points that differ", "command lost", "end of the cut after, ms"),
             "|---|---:|---:|---:|"]  # fmt: skip
    for key in flat:
        if key.startswith("bus_") and key.endswith("_told_otherwise"):
            stem = key.removesuffix("_told_otherwise")
            name = stem.removeprefix("bus_").replace("_", " ")
            lost = flat[f"{stem}_losses_of_command"]
            rows.append(row(name, flat[key], lost, flat[f"{stem}_ms_to_disengaging"]))
    rows += [
        "\n### Supply\n",
        row("what", "falls", "old", "new", "neither"),
        "|---|---:|---:|---:|---:|",
    ]
    for name, title in (
        ("power_stm", "download into the flash of the H743, and the log of what is in use"),
        ("power_linux", "table, parameters and black box of the Linux port"),
    ):
        rows.append(row(title, *(flat[f"{name}_{k}"] for k in ("falls", "old", "new", "wrong"))))
    rows += ["\n### Hours\n", row("tick rate, kHz", "hours", "ticks, million"), "|---:|---:|---:|"]
    for hz in (20000, 5000, 2000, 1000):
        ticks = int(flat[f"hours_ticks_at_{hz}_hz"]) / 1e6
        rows.append(row(hz / 1000, flat[f"hours_hours_at_{hz}_hz"], f"{ticks:.1f}"))
    rows.append(row("all", flat["hours_hours"], f"{int(flat['hours_ticks']) / 1e6:.1f}"))
    rows += [
        "",
        f"{flat['hours_parts']} parts were cut to their ends, {flat['hours_stopped']} cuts were "
        f"stopped, {flat['hours_faults']} faults latched, in {flat['hours_sessions']} sessions; "
        f"seed {flat['hours_seed']}.",
    ]
    rows += ["", row("fault", "times latched"), "|---|---:|"]
    rows += [
        row(f"`{k.removeprefix('hours_latched_')}`", v)
        for k, v in flat.items()
        if k.startswith("hours_latched_")
    ]
    return "\n".join(rows) + "\n"


def write_readme(flat: Figures) -> None:
    """Put the tables into README.md, between their marks."""
    path = HERE / "README.md"
    begin, _, rest = path.read_text("utf-8").partition("<!-- figures -->\n")
    _, _, end = rest.partition("<!-- end of figures -->\n")
    marks = ("<!-- figures -->\n", "<!-- end of figures -->\n")
    path.write_text(begin + marks[0] + tables(flat) + marks[1] + end, "utf-8")


def arguments() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(prog="tests/campaign/run", description=__doc__)
    parser.add_argument("--hours", type=float, default=24.0, help="of machine time (24)")
    parser.add_argument("--seed", type=int, default=1, help="of all that happens at random (1)")
    parser.add_argument("--jobs", type=int, default=2, help="programs at a time (2)")
    parser.add_argument(
        "--record", action="store_true", help="write figures.json and the tables of README.md"
    )
    asked = parser.parse_args()
    if asked.hours <= 0.0 or asked.jobs < 1 or asked.seed < 1:
        parser.error("--hours, --jobs and --seed: give a number above 0")
    return asked


def main() -> int:
    """Run the campaign; return 0 when nothing was found."""
    asked = arguments()
    WORK.mkdir(parents=True, exist_ok=True)
    began = time.monotonic()
    flat: Figures = {}
    wrong: list[str] = []
    for found, why in (
        power(),
        bus(),
        reactions(asked.jobs),
        hours(asked.hours, asked.seed, asked.jobs),
    ):
        flat |= found
        wrong += why
    flat = {"seconds": round(time.monotonic() - began), "found": len(wrong)} | flat
    FIGURES.write_text(json.dumps(flat, indent=2) + "\n", "utf-8")
    if not wrong:
        print(tables(flat), end="")
    if asked.record and not wrong:
        (HERE / "figures.json").write_text(json.dumps(flat, indent=2) + "\n", "utf-8")
        write_readme(flat)
    for line in wrong:
        print(f"found: {line}", file=sys.stderr)
    print(f"{flat.get('hours_hours', 0)} hours, {len(CASES)} disturbances, {len(wrong)} findings")
    return 1 if wrong else 0


if __name__ == "__main__":
    os.chdir(ROOT)
    sys.exit(main())
