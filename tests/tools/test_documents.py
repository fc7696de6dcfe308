"""Commands of the documents: known, with options that exist, and run where a computer suffices."""

import argparse
import json
import re
import shutil
from collections.abc import Callable, Collection, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path

import can
import pytest

from camtools.base import arguments
from camtools.cli import camctl
from checks.patience import limit_s
from tests.tools.cases.camctl_bench import Bench, linked
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.command_cases import command
from tests.tools.cases.documents import Documented, blocks_of, commands_of, files_of, is_command
from tests.tools.cases.part_cases import ROOT, Capture, TableOf
from tests.tools.test_citations import texts

PAGES = sorted(name for name in texts() if name.endswith(".md") and "CHANGES" not in name)
FOLDERS = ("tools/", "tests/", "hal/", "host_sim/", "firmware/")
MODULES = {
    "camctl": "camtools.cli.camctl",
    "tools/elfcheck": "checks.elfcheck",
    "tools/misra": "checks.misra",
    "tests/campaign/run": "tests.campaign.campaign",
    "tests/fuzz/run": "tests.fuzz.fuzzing",
    "tests/mutation/run": "tests.mutation.mutation",
    "tests/proof/run": "tests.proof.prove",
} | {
    f"tools/{path.stem}": f"camtools.cli.{path.stem}" for path in ROOT.glob("tools/camtools/cli/*")
}
SCRIPTS = {name: name for name in ("tools/test", "tools/uml", "tools/verify", "tests/busy/run")} | {
    "build/linux/hal/linux/camturn-linux": "hal/linux/lin_options.c"
}
# Why the other programs are not even asked for their options.
NOT_ASKED = {
    "a program of a shell": "cd cp cut echo export kill mkdir sed sleep .",
    "needs root": "sudo journalctl",
    "of others": "make pip cpack cantools dask caddy ssh python3 build/venv/bin/python",
    "needs LinuxCNC: tests/linuxcnc": "halcmd linuxcnc",
    "needs a board": "openocd st-flash pyocd",
    "replayed below": "cansend candump",
    "pytest's options": "tests/linux/run",
}
WITHOUT_OPTIONS = {"pytest", "camtools.papers.size_by_tolerance"}  # or with those of others
OTHERS = {name for names in NOT_ASKED.values() for name in names.split()}


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory, table_of: TableOf) -> Path:
    """Return a folder like the top of a clone, with a table and the files that pages print."""
    folder = tmp_path_factory.mktemp("desk")
    for path in ROOT.iterdir():
        if path.name not in ("build", ".git"):
            (folder / path.name).symlink_to(path)
    for page in PAGES:
        for name, text in files_of(texts()[page]).items():
            (folder / name).write_text(text, "utf-8")
    shutil.copytree(table_of("perkins240").parent, folder / "build" / "parts")
    return folder


class ParsedError(Exception):
    """The options are understood; nothing is done."""


def _stopped(read: Callable[..., object]) -> Callable[..., None]:
    def reads(*words: object, **settings: object) -> None:
        read(*words, **settings)
        raise ParsedError

    return reads


def complaint_of(module: str, words: Sequence[str], capture: Capture) -> str:
    """Return what a program in Python complains of its arguments, "" if nothing."""
    ours = module.startswith("camtools")
    with pytest.MonkeyPatch.context() as patch:
        if ours:
            for place in (arguments, camctl):
                patch.setattr(place, "read_arguments", _stopped(arguments.read_arguments))
        else:
            read = _stopped(argparse.ArgumentParser.parse_args)
            patch.setattr(argparse.ArgumentParser, "parse_args", read)
        try:
            import_module(module).main(list(words))
        except ParsedError:
            return ""
        except SystemExit as end:
            said = capture.readouterr()
            return said.err if end.code else ""  # --help
    return "not parsed"


def _python(one: Documented, capture: Capture) -> str:
    module, words = MODULES.get(one.words[0]), one.words[1:]
    if module is None and "-m" not in words:
        return ""  # a program of the tests
    if module is None:
        at = one.words.index("-m") + 1
        module, words = one.words[at], one.words[at + 1 :]
        if module in WITHOUT_OPTIONS:
            return ""
    values = {"AXIS": "x", "N": "1", "K": "1", "R": "1"}
    complaint = complaint_of(module, [values.get(word, word) for word in words], capture)
    is_unknown = "unrecognized" in complaint or "invalid choice" in complaint
    return complaint if is_unknown or not one.is_inline else ""


@cache
def _help(command: str) -> str:
    return camsim(command, "--help").stdout


def _presets() -> set[str]:
    found = json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]
    return {preset["name"] for preset in found} | {"PRESET"}


def wrong_with(one: Documented, capture: Capture) -> str:
    """Return what is wrong with a command, "" if nothing."""
    name, *words = one.words
    if "--help" in words:
        return ""
    missing = [
        word
        for word in one.words
        if word.startswith(FOLDERS) and "*" not in word and not (ROOT / word).exists()
    ]
    if missing:
        return f"{missing[0]} does not exist"
    if name in MODULES or name.endswith("/python"):
        return _python(one, capture)
    options = [word.partition("=")[0] for word in words if word.startswith("-")]
    if name.endswith("camsim") and words:
        text = _help(words[0])
    elif name in SCRIPTS:
        text = (ROOT / SCRIPTS[name]).read_text()
    elif name in ("cmake", "ctest"):
        named = [words[i + 1] for i, word in enumerate(words) if word == "--preset"]
        return "" if {*named} <= _presets() else "no such preset"
    elif name in OTHERS or name.startswith("build/"):
        return ""
    else:
        return "" if one.is_inline else "unknown program"
    known = set(re.findall(r"-[\w-]+", text))
    return next((f"no option {option}" for option in options if option not in known), "")


PAGE = """
    A=1 tools/run [x]    # why
    (cp a b >c && kill %1) &

```
camsim run \\
--feed 1
```
`tools/x`, `no/command`
"""


def test_pages_are_read_as_a_shell_does() -> None:
    """Settings, notes, redirections and brackets are no words; lines may continue."""
    found = [f"{one.line} {' '.join(one.words)}" for one in commands_of("README.md", PAGE)]
    assert found == ["2 tools/run x", "3 cp a b", "3 kill %1", "6 camsim run --feed 1", "9 tools/x"]


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_known(
    page: str, desk: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    """Programs, options, presets and files of the repository exist."""
    monkeypatch.chdir(desk)
    found = commands_of(page, texts()[page])
    wrong = {str(one): problem for one in found if (problem := wrong_with(one, capsys))}
    assert wrong == {}


# Sections whose commands for a controller run here; `unlock` waits for somebody at the machine.
ON_A_BENCH = [
    ("hal/linux/README.md", "First steps"),
    ("tools/docs/CAMCTL.md", "Set up a machine once"),
]


@pytest.mark.parametrize(("page", "title"), ON_A_BENCH)
def test_camctl_of_a_page_succeeds(
    page: str, title: str, bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each line, in their order."""
    monkeypatch.chdir(tmp_path)
    section = texts()[page].partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    orders = [one.words[1:] for one in commands_of(page, section) if one.words[0] == "tools/camctl"]
    orders = [words for words in orders if words != ("unlock",)]
    assert len(orders) > 2
    for words in orders:
        bench.do(*words)


def test_frames_of_the_protocol_get_the_printed_answers(bench: Bench) -> None:
    """Those of can-utils, with the session that the controller gave."""
    text = texts()["firmware/remote/can/README.md"]
    lines = re.findall(r"cansend can0 640#(\S{14,}).*# .* -> 5C0((?: [0-9A-F]{2}){8})", text)
    assert len(lines) == 5
    session = ""
    with linked(bench) as link:
        for sent, printed in lines:
            data = bytes.fromhex(sent.strip(")").replace("${session}", session))
            link.bus.send(can.Message(arbitration_id=0x640, data=data, is_extended_id=False))
            answer = ""
            while not answer.startswith(f"{data[0]:02x}"):
                frame = link.bus.recv(limit_s())
                assert frame is not None, sent
                answer = frame.data.hex() if frame.arbitration_id == 0x5C0 else ""
            if not session:  # of the answer to take_command; the page has 07
                session = answer[8:10]
                answer = f"{answer[:8]}07{answer[10:]}"
            assert bytes.fromhex(answer) == bytes.fromhex(printed), sent


RUNS = ("tools/mktables", "tools/mkgcode", "camsim")
LONG_RUNS = (*RUNS, "tools/run", "tools/analyse", "build/host/host_sim/camsim")
FAILS = {"--inject": 1} | dict.fromkeys(("round0", "free0", "free1"), 1)  # out of tolerance
GIVEN = {"NAME.camtab": "build/parts/perkins240.camtab", "/tmp": "build/parts"}
# Files and numbers of the reader, other processes; a trace takes 200 MB, a forecast many cuts.
WANTING = {"PART.toml", "DIR", "N", "M.toml", "--wave", "--wire", "--can", "--trace", "--forecast"}


def to_be_run(page: str, programs: Collection[str]) -> list[Documented]:
    """Return the commands of the blocks of a page that need nothing else."""
    found = commands_of(page, texts()[page])
    return [
        one
        for one in found
        if one.words[0] in programs and not one.is_inline and not WANTING & set(one.words)
    ]


def ran(page: str, programs: Collection[str], desk: Path) -> str:
    """Run some programs of a page in their order; return what they printed."""
    printed = ""
    for one in to_be_run(page, programs):
        name, *words = [GIVEN.get(word, word) for word in one.words]
        if name == "tools/run" and "-o" not in words:
            words = ["-o", "build/run", *words]  # not among the runs of the clone
        if name in MODULES:
            done = command(MODULES[name], *words, cwd=desk, draws=False)
        else:
            done = camsim(*words, stdin="turn,z_mm\n", cwd=desk)
        expected = next((FAILS[word] for word in words if word in FAILS), 0)
        assert done.returncode == expected, f"{one}: {done.stderr}"
        printed += done.stdout
    return printed


@pytest.mark.parametrize("page", [page for page in PAGES if to_be_run(page, RUNS)])
def test_commands_without_a_machine_run(page: str, desk: Path) -> None:
    """They succeed from the top of a clone."""
    ran(page, RUNS, desk)


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page in PAGES if to_be_run(page, LONG_RUNS)])
def test_long_commands_without_a_machine_run(page: str, desk: Path) -> None:
    """They succeed from the top of a clone."""
    ran(page, LONG_RUNS, desk)


def test_first_part_prints_what_its_page_shows(desk: Path) -> None:
    """The lines of the table, of the refusal of a faster spindle, and of the cut."""
    page = "tools/docs/FIRST_PART.md"
    text = texts()[page]
    [setting] = re.findall(r"^Set `(\w+ = \d+)`", text, re.MULTILINE)
    part = desk / "mine.toml"
    slow = part.read_text()
    printed = ran(page, ("tools/mktables",), desk)
    part.write_text(re.sub(rf"{setting.split()[0]} = \d+", setting, slow))
    printed += command(MODULES["tools/mktables"], part.name, "-o", "build", cwd=desk).stderr
    part.write_text(slow)
    printed += ran(page, ("tools/run",), desk)
    shown = [line for block in blocks_of(text) for line in block.lines if not block.language]
    shown = [line for line in shown if not is_command(line) and line != "..."]
    assert len(shown) == 7
    lines = [line.strip() for line in printed.splitlines()]
    assert [line for line in shown if line not in lines] == []
