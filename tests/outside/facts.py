# SPDX-License-Identifier: Apache-2.0
"""What the outside sees of camturn: command lines, tables, cuts, files, CAN messages.

Nothing of camtools is imported and no source is read: commands of tools/, camsim and the bench of
the CAN tests are started, and files are found by name. So it works on any state of the repository.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.outside import can_session
from tests.outside.inputs import ROOT, found, make, parts

Fact = str | int | float | bool | None | list[str]
Facts = dict[str, Fact]

COMMANDS = Path(__file__).with_name("commands.txt")
BUILD = Path(os.environ.get("CAMTURN_BUILD") or ROOT / "build" / "host").resolve()
WHOLE_LINE = re.compile(r"^camturn: .*\n", re.MULTILINE)  # progress of the set-up
NUMBER = re.compile(r" *[+-]? *\b\d+(?:\.\d+)?(?:e[+-]?\d+)?\b")
DECIMAL = re.compile(r" *[+-]? *\b\d+\.\d+(?:e[+-]?\d+)?\b")
PATH = re.compile(r"\b(?:[\w-]+/)+([\w-]+\.(?:h|c|md|py|toml|dbc))\b")
SOURCE = re.compile(r'"source": "(.*)"')  # words about the part in its report
PORT = re.compile(r"(?<=@127\.0\.0\.1:)\d+")

_CAM = ("--machine", "cam.machine", "--set", "engage_turns=1", "--set", "disengage_turns=1")
# How each part is cut: at the table's speed and feed unless said otherwise.
CUTS: dict[str, tuple[str, ...]] = {
    "perkins240": ("--nose-mm", "0.8"),
    "perkins240_x30": ("--machine", "long.machine"),
    "cam-345": (*_CAM, "--feed", "1"),
    "cam-345-ground": (*_CAM, "--feed", "1"),
    "cam-disc": (*_CAM, "--feed", "1"),
    "camshaft": (*_CAM, "--feed", "0.25"),
}
# Other cuts of the first part: what parts of the controller are worth, other machines.
VARIANTS: dict[str, tuple[str, ...]] = {
    "slow": ("--rpm", "240"),
    "no lead": ("--feed", "1", "--no-lead"),
    "no feed-forward": ("--feed", "1", "--no-feed-forward"),
    "rough": ("--machine", "rough.machine"),
    "piezo": ("--machine", "piezo.machine"),
}
PROGRAMS = (("perkins240", ("--axes", "xz")), ("perkins240_ring_helix", ("--axes", "cxzu")))


@cache
def built(name: str) -> Path:
    """Return the one program of a name in the build folder."""
    (path,) = (p for p in BUILD.rglob(name) if p.is_file() and os.access(p, os.X_OK))
    return path


def command_of(tool: str) -> list[str]:
    """Return the words that start a command.

    Without the project's own environment for Python the script would make one: what it would start
    in the end is started by the present interpreter.
    """
    if tool == "camsim":
        return [str(built("camsim"))]
    script = ROOT / "tools" / tool
    module = re.search(r"^exec .* -m ([\w.]+) ", script.read_text(), re.MULTILINE)
    if module is None or (ROOT / "build" / "venv").exists():
        return [str(script)]
    return [sys.executable, "-m", module[1]]


def environment(**more: str) -> dict[str, str]:
    """Return the environment of a command: one language, one width, no settings of a user."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("CAN_")}
    path = os.pathsep.join(filter(None, [str(ROOT / "tools"), os.environ.get("PYTHONPATH")]))
    fixed = {"LC_ALL": "C.UTF-8", "COLUMNS": "80", "NO_COLOR": "1", "CAMTURN_BUILD": str(BUILD)}
    return kept | fixed | {"PYTHONPATH": path} | more


def plain(text: str, folder: Path) -> str:
    """Return output without what differs from place to place."""
    for path, name in ((folder, "<TMP>"), (BUILD, "<BUILD>"), (ROOT, "<ROOT>")):
        text = text.replace(f"{path}/", f"{name}/").replace(str(path), name)
    return without_folders(PORT.sub("PORT", WHOLE_LINE.sub("", text)))


def without_folders(text: str) -> str:
    """Return text with the names only of files of the repository.

    They may move as long as the path that is told leads to them.
    """
    return PATH.sub(lambda one: f"<{one[1]}>" if (ROOT / one[0]).exists() else one[0], text)


def names_in(folder: Path) -> set[str]:
    """Return the names of all files below a folder."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


class Shop:
    """A folder in which tables are made once.

    Attributes
    ----------
    folder : Path
        of the tables
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock = threading.Lock()

    def table(self, part: str) -> Path:
        """Return the table of a part of the repository, its report beside it."""
        path = self.folder / part / f"{part}.camtab"
        with self._lock:
            if not path.exists():
                words = [*command_of("mktables"), str(parts()[part]), "-o", str(path.parent)]
                subprocess.run(words, env=environment(), check=True, capture_output=True)
        return path

    def keep(self, part: str, files: dict[str, bytes]) -> None:
        """Keep the files of a table that was made already."""
        folder = self.folder / part
        with self._lock:
            if not folder.exists():
                folder.mkdir()
                for name, data in files.items():
                    (folder / name).write_bytes(data)

    def run(
        self, words: list[str], mask: re.Pattern[str] | None = None, **settings: str
    ) -> tuple[list[str], dict[str, bytes]]:
        """Run a command in a folder with the files that it names.

        Parameters
        ----------
        words : list of str
            the command line; `< FILE` is its standard input
        mask : pattern
            what is replaced in the output of a command that was not refused

        Returns
        -------
        list of str
            status, lines of output, names of the files that are new
        dict
            those files by their names
        """
        with TemporaryDirectory(prefix="outside") as name:
            folder = Path(name)
            for word in [*words, *(part for v in settings.values() for part in v.split(":"))]:
                make(word, folder, self.table)
            before = names_in(folder)
            source = None
            if "<" in words:
                source = (folder / words[-1]).read_bytes()
                words = words[: words.index("<")]
            for key, value in settings.items():
                settings[key] = value.replace("fakes:", f"{folder}/fakes:")
            done = subprocess.run(
                [*command_of(words[0]), *words[1:]],
                cwd=folder,
                env=environment(**settings),
                input=source if source is not None else b"",
                capture_output=True,
                timeout=120,
                check=False,
            )
            out, err = (plain(text.decode(), folder) for text in (done.stdout, done.stderr))
            if mask is not None and done.returncode != 2:
                out, err = mask.sub(" #", out), mask.sub(" #", err)
            left = sorted(names_in(folder) - before)
            files = {one: (folder / one).read_bytes() for one in left if (folder / one).is_file()}
        told = [f"status {done.returncode}"]
        told += [f"> {line}" for line in out.splitlines()]
        told += [f"! {line}" for line in err.splitlines()]
        return told + [f"+ {one}" for one in left], files


def command_lines(tool: str) -> list[str]:
    """Return the lines of commands.txt that start a command of tools/, or camsim."""
    lines = COMMANDS.read_text().splitlines()
    return [line for line in lines if line and line[0] != "#" and tool_of(line) == tool]


def tool_of(line: str) -> str:
    """Return the command that a line starts."""
    return next(word for word in line.split() if "=" not in word)


def command_facts(shop: Shop, tool: str) -> Facts:
    """Return what the command lines of a tool give."""
    masks = {"run": NUMBER, "scallop": NUMBER, "camsim": DECIMAL}

    def outcome(line: str) -> list[str]:
        words, settings = shlex.split(line), dict[str, str]()
        while "=" in words[0]:
            name, _, value = words.pop(0).partition("=")
            settings[name] = os.path.expandvars(value)
        is_plain = {"eval", "--help", "--version"} & set(words)
        return shop.run(words, None if is_plain else masks.get(words[0]), **settings)[0]

    return {line: outcome(line) for line in command_lines(tool)}


def digest(data: bytes) -> str:
    """Return size and checksum of a file."""
    return f"{len(data)} bytes, sha256 {hashlib.sha256(data).hexdigest()[:24]}"


def flat(value: Any, name: str = "") -> Iterator[tuple[str, Fact]]:  # noqa: ANN401 - JSON
    """Yield the leaves of a summary with their dotted names; lists of texts stay whole."""
    if isinstance(value, dict) and value:
        for key, one in value.items():
            yield from flat(one, f"{name}.{key}" if name else key)
    elif isinstance(value, list) and any(isinstance(one, dict) for one in value):
        for i, one in enumerate(value):
            yield from flat(one, f"{name}.{i}")
    elif isinstance(value, dict | list):
        yield name, [str(one) for one in value]
    else:
        yield name, value


CLOCK = ("wall_time_s", "ticks_per_s")


def summary_facts(title: str, data: bytes) -> Facts:
    """Return the values of a summary, its parameters in one fact."""
    summary = json.loads(data)
    parameters = [f"{key} = {value}" for key, value in summary.pop("parameters").items()]
    values = {f"{title}: {key}": value for key, value in flat(summary) if key not in CLOCK}
    return values | {f"{title}: keys": sorted(summary), f"{title}: parameters": parameters}


def cut_facts(shop: Shop, title: str, part: str, options: tuple[str, ...]) -> Facts:
    """Return what a cut leaves: its summary and the columns of its files."""
    outputs = ["--summary", "s.json"]
    told, files = shop.run(["camsim", "run", f"{part}.camtab", *options, *outputs], DECIMAL)
    facts: Facts = {f"{title}: status and output": told}
    return facts | summary_facts(title, files["s.json"])


def part_facts(shop: Shop, part: str) -> Facts:
    """Return the files that mktables makes of a part, its output, and how it is cut."""
    told, files = shop.run(["mktables", f"{part}.toml", "-o", "."])
    shop.keep(part, files)
    facts: Facts = {f"table {part}: status and output": told}
    for name, data in sorted(files.items()):
        if not name.endswith(".camtab"):
            text, sources = data.decode(), re.findall(SOURCE, data.decode())
            data = without_folders(re.sub(SOURCE, "", text)).encode()
            facts |= {f"table {part}: source in {name}": one for one in sources}
        facts[f"table {part}: {name}"] = digest(data)
    return facts | cut_facts(shop, f"cut {part}", part, CUTS.get(part, ()))


def variant_facts(shop: Shop, name: str) -> Facts:
    """Return how the first part is cut in another way."""
    return cut_facts(shop, f"cut perkins240, {name}", "perkins240", VARIANTS[name])


def file_facts(shop: Shop) -> Facts:
    """Return the columns of all tables that a cut can write."""
    facts: Facts = {}
    options = ["--trace", "trace.csv", "--surface", "surface.csv", "--removal", "removal.csv"]
    scallop = ["--nose-mm", "1", "--scallop", "scallop.csv"]
    for part, words in (
        ("perkins240", [*options, *scallop, "--feed", "1", "--turns-limit", "8"]),
        ("cam-345", [*options[:4], *CUTS["cam-345"], "--turns-limit", "1"]),
    ):
        _, files = shop.run(["camsim", "run", f"{part}.camtab", *words])
        for name, data in files.items():
            facts[f"columns of {name} of {part}"] = data.split(b"\n", 1)[0].decode().split(",")
    return facts


def program_facts(shop: Shop) -> Facts:
    """Return NC programs and the tables of the analysis by checksum, the files of a whole run."""
    facts: Facts = {}
    for part, words in PROGRAMS:
        line = ["mkgcode", f"{part}.toml", "-o", "part.ngc", *words]
        told, files = shop.run(line)
        facts[" ".join(line)] = [*told, digest(files["part.ngc"])]
    told, files = shop.run(["analyse", "perkins240.toml", "-o", "out"])
    facts["analyse perkins240.toml: status and output"] = told
    facts |= {f"analyse: {n}": digest(d) for n, d in files.items() if not n.endswith("png")}
    return facts


def run_facts(shop: Shop, part: str) -> Facts:
    """Return the output of tools/run, the files that it leaves and the keys of its summary."""
    line = ["run", f"{part}.toml", "--feed", "2", "-o", "out"]
    if part.startswith("cam"):
        line += ["--", "--set", "engage_turns=1", "--set", "disengage_turns=1"]
    told, files = shop.run(line, NUMBER)
    summary = json.loads(files["out/summary.json"])
    facts: Facts = {" ".join(line): told}
    keys = {key for key, _ in flat(summary) if not key.startswith("parameters.")}
    facts[f"run {part}: keys of summary.json"] = sorted(keys)
    page = re.sub(r"data:[^\"]*", "", files["out/report.html"].decode())
    titles = re.findall(r"<(?:title|h1|h2|h3|figcaption|th)[^>]*>([^<]*)", page)
    facts[f"run {part}: report.html"] = [NUMBER.sub(" #", title) for title in titles]
    machine = f"out/{part}_machine.toml"
    facts[f"run {part}: machine file"] = files[machine].decode().splitlines()
    return facts


def can_facts(shop: Shop) -> Facts:
    """Return the messages as the DBC tells them, and a session of camctl with a controller."""
    dbc = found("camturn.dbc")
    facts: Facts = {"camturn.dbc": digest(dbc.read_bytes())}
    with can_session.Controller(built("can_bench"), dbc) as controller:
        for line in can_session.LINES:
            words = ["camctl", "-i", "socketcand", "-c", "can0", *shlex.split(line)]
            mask = None if line.startswith(can_session.EXACT) else DECIMAL
            if line.startswith(can_session.MASKED):
                mask = NUMBER
            told, files = shop.run(words, mask, CAN_CONFIG=controller.config)
            heads = [f"{name}: {data.splitlines()[0].decode()}" for name, data in files.items()]
            told = [one for one in told + heads if not one.startswith(can_session.NOISE)]
            facts[f"camctl session: {line}"] = told + controller.frames()
        facts["camctl session: messages of the status"] = controller.periodic()
    return facts


Group = Callable[[Shop], Facts]
TOOLS = sorted({tool_of(line) for line in COMMANDS.read_text().splitlines() if line[:1].isalnum()})
TOOLS.sort(key=lambda tool: -len(command_lines(tool)) * (tool != "camsim"))
GROUPS: dict[str, Group] = {  # the longest first
    "can": can_facts,
    **{f"commands {tool}": partial(command_facts, tool=tool) for tool in TOOLS},
    **{f"part {part}": partial(part_facts, part=part) for part in parts()},
    **{f"cut {name}": partial(variant_facts, name=name) for name in VARIANTS},
    "columns": file_facts,
    "programs": program_facts,
    "run perkins240": partial(run_facts, part="perkins240"),
    "run cam-disc": partial(run_facts, part="cam-disc"),
}
