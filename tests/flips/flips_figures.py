# SPDX-License-Identifier: Apache-2.0
"""Counts the classes of a campaign; its figures and the tables of README.md that follow from them.

>>> round(most_percent(0, 300), 2)
0.99
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from flips_campaign import Outcome
from flips_judge import CLASSES, WRONG
from flips_listed import read_listed
from flips_plan import SHARES
from scipy.stats import beta

HERE = Path(__file__).resolve().parent
NOTICED = ("detected", "stopped", "main")
HEADINGS = {
    "none": "no effect",
    "small": "within the course",
    "out": "away from the work",
    "detected": "retracted",
    "stopped": "stopped at once",
    "main": "stopped, main loop",
    "limits": "wrong: limits",
    "course": "wrong: course",
}


def most_percent(n_wrong: int, n: int) -> float:
    """Return the upper bound of the share, at 95 %, by Clopper and Pearson."""
    return 100.0 * float(beta.ppf(0.95, n_wrong + 1, n - n_wrong)) if n_wrong < n else 100.0


def key_of(stratum: str) -> str:
    """Return the name of a stratum in the figures."""
    return stratum.replace(", ", "_").replace(" ", "_")


def figures(
    outcomes: Sequence[Outcome],
    sizes: Mapping[str, int],
    seed: int,
    kinds: Mapping[str, Sequence[Outcome]],
) -> dict[str, float]:
    """Return everything as one flat object."""
    flat: dict[str, float] = {"seed": seed, "count": len(outcomes), "unlisted": len(kinds[""])}
    flat |= {f"listed.{name}": len(found) for name, found in kinds.items() if name}
    every = Counter(o.verdict.kind for o in outcomes)
    for stratum in SHARES:
        count = Counter(o.verdict.kind for o in outcomes if o.strike.stratum == stratum)
        flat |= {f"{key_of(stratum)}.{kind}": count[kind] for kind in CLASSES}
        flat[f"{key_of(stratum)}.bytes"] = sizes[stratum]
    flat |= {f"all.{kind}": every[kind] for kind in CLASSES}
    flat["noticed"] = sum(every[kind] for kind in NOTICED)
    n_wrong = flat["wrong"] = sum(every[kind] for kind in WRONG)
    flat["wrong_percent"] = round(100.0 * n_wrong / len(outcomes), 2)
    flat["wrong_most_percent"] = round(most_percent(int(n_wrong), len(outcomes)), 2)
    return flat


def table(flat: Mapping[str, float]) -> str:
    """Return the table of the classes."""
    names = [*SHARES, "all"]
    lines = [
        "| stratum | bytes | flips | " + " | ".join(HEADINGS.values()) + " | wrong at most |",
        "|---" + "|---:" * (len(HEADINGS) + 3) + "|",
    ]
    for name in (n for n in names if any(flat[f"{key_of(n)}.{kind}"] for kind in CLASSES)):
        counts = [int(flat[f"{key_of(name)}.{kind}"]) for kind in CLASSES]
        n_wrong = sum(c for c, kind in zip(counts, CLASSES, strict=True) if kind in WRONG)
        most = most_percent(n_wrong, sum(counts))
        size = int(flat.get(f"{key_of(name)}.bytes", 0))
        cells = [name, str(size or ""), str(sum(counts)), *map(str, counts), f"{most:.2f} %"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def listed_table(flat: Mapping[str, float]) -> str:
    """Return the table of what is listed."""
    lines = ["| struck | seen | moves | why nothing prevents it |", "|---|---:|---|---|"]
    for kind in read_listed():
        seen = int(flat[f"listed.{kind.name}"])
        lines.append(f"| {kind.stratum}: {kind.name} | {seen} | {kind.moves} | {kind.why} |")
    return "\n".join(lines) + "\n"


def told(flat: Mapping[str, float]) -> dict[str, str]:
    """Return what README.md holds between which marks."""
    now = (
        f"As recorded, seed {flat['seed']:.0f}: {flat['noticed']:.0f} of {flat['count']:.0f} flips"
        f" were noticed, {flat['wrong']:.0f} were wrong, {flat['wrong_percent']} %.\n"
    )
    return {"figures": table(flat), "listed": listed_table(flat), "now": now}


def recorded() -> dict[str, float]:
    """Return the figures of the campaign that was recorded."""
    flat: dict[str, float] = json.loads((HERE / "figures.json").read_text("utf-8"))
    return flat


def record(flat: Mapping[str, float]) -> None:
    """Keep the figures, and write their tables into README.md."""
    (HERE / "figures.json").write_text(json.dumps(flat, indent=1) + "\n", "utf-8")
    readme = HERE / "README.md"
    text = readme.read_text("utf-8")
    for name, rows in told(flat).items():
        begin, _, rest = text.partition(f"<!-- {name} -->\n")
        end = rest.partition(f"<!-- end of {name} -->")[2]
        text = f"{begin}<!-- {name} -->\n{rows}<!-- end of {name} -->{end}"
    readme.write_text(text, "utf-8")
