"""The command line: files complete or absent, exit status, C that compiles."""

import json
import os
import shutil
import signal
import subprocess
import sys
import zlib
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.cli.mktables import main
from camtools.pipeline.load import Made
from camtools.skirt.kind import KIND
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.summary import emit_header, emit_source, identifier
from tests.tools.cases.cut_cases import written
from tests.tools.cases.part_cases import PERKINS, ROOT, Command, environment, listing, sure

STRICT_C = ["-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wpedantic", "-Werror"]
NAMES = ["perkins240.camtab", "perkins240.json", "perkins240_table.c", "perkins240_table.h"]


def test_all_files_are_written(mktables: Command, tmp_path: Path) -> None:
    """A good part gives exit status 0, files and PNG images, a summary, and nothing on stderr."""
    folder = tmp_path / "new" / "deep"
    run = mktables(PERKINS, "-o", folder, "--plot")
    assert (run.returncode, run.stderr) == (0, "")
    pictures = [f"perkins240_{name}.png" for name in ("motion", "profile", "section")]
    assert listing(folder) == sorted([*NAMES, *pictures])
    assert all((folder / one).read_bytes().startswith(b"\x89PNG\r\n\x1a\n") for one in pictures)
    assert run.stdout.startswith("perkins240: table of 3456 bytes\n")


def test_script_gives_the_same_from_anywhere(generated: GeneratedSkirt, tmp_path: Path) -> None:
    """Through a symbolic link, from another folder, with spaces: the bytes made in this process."""
    if not (ROOT / "build" / "venv" / "bin" / "python").exists():
        pytest.skip("build/venv is not set up")
    (tmp_path / "my tables").symlink_to(ROOT / "tools" / "mktables")
    shutil.copy(PERKINS, tmp_path / "my part.toml")
    words = ["./my tables", "my part.toml", "-o", "my out"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    files = Made(KIND, generated).files(with_plots=False)
    assert listing(tmp_path / "my out") == sorted(files)
    for name, data in files.items():
        assert (tmp_path / "my out" / name).read_bytes() == data, name


def test_json_tells_what_was_chosen(generated: GeneratedSkirt) -> None:
    """The report is JSON with sorted keys, and agrees with the image."""
    files = Made(KIND, generated).files(with_plots=False)
    text, image = files["perkins240.json"].decode(), files["perkins240.camtab"]
    report = json.loads(text)
    assert text == json.dumps(report, indent=1, sort_keys=True) + "\n"
    assert report["table_bytes"] == len(image)
    assert report["table_crc32"] == zlib.crc32(image[24:])
    assert report["channels"]["u"]["n_slices"] == 32
    assert report["error"]["u"]["value_nm"] <= 1.0
    assert report["motion"]["velocity_mm_s"] == pytest.approx(39.27, abs=0.001)
    assert report["feasibility"]["decided_by"] == "spindle_rpm"
    assert report["process"]["magnify"] == 1.0
    assert report["guaranteed"]["u_min_nm"] in (-1, 0)


def bad_parts() -> dict[str, tuple[bytes, str]]:
    """Return bad part files and the words that stderr must contain."""
    good = PERKINS.read_bytes()
    return {
        "binary": (b"\xff\x00", "not UTF-8"),
        "unknown": (good + b"[extra]\n", "extra: unknown key; remove it"),
        "slow": (good.replace(b"= 400", b"= 10"), "machine.limits.u_speed_mm_s = 10 mm/s"),
        "short": (good.replace(b"= 1.2", b"= 0.1"), "machine.limits.u_stroke_mm = 0.1 mm"),
        "fast": (good.replace(b"= 2500", b"= 3001"), "machine.limits.spindle_rpm = 3000 r/min"),
        "coarse": (
            good.replace(b"[0, 10, 20, 30, 40, 50, 62]", b"[0, 1, 2, 3, 4, 6, 8]").replace(
                b"feed_mm = 0.1", b"feed_mm = 8.000001"
            ),
            "process.feed_mm = 8.000001: must be at most 8, the height of the part; give mm per",
        ),
        "coarse-cam": (
            PERKINS.with_name("cam-345.toml")
            .read_bytes()
            .replace(b"[0, 12]", b"[0.5, 4]")
            .replace(b"[process]", b"[process]\nfeed_mm = 5"),
            "process.feed_mm = 5: must be at most 3.5, the height of the part; give mm per turn",
        ),
        "inside-out": (good + b"[magnify]\nfactor = 1000\n", "magnify.factor: "),
    }


@pytest.mark.parametrize("name", list(bad_parts()))
def test_bad_part_leaves_nothing(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A bad part gives exit status 2, lines with file and field, and no output folder."""
    data, words = bad_parts()[name]
    part = tmp_path / f"{name}.toml"
    part.write_bytes(data)
    assert main([str(part), "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert all(line.startswith(f"mktables: {part}: ") for line in err.splitlines())
    assert listing(tmp_path) == [part.name]


def test_generated_c_is_the_image(tmp_path: Path, generated: GeneratedSkirt) -> None:
    """The C source compiles without a warning and holds the image's bytes, aligned to 32."""
    compiler = sure(shutil.which("gcc") or shutil.which("cc"))
    written(Made(KIND, generated), tmp_path)
    (tmp_path / "main.c").write_text(
        '#include "perkins240_table.h"\n#include <stdio.h>\nint main(void)\n{\n'
        "    if (((uintptr_t)perkins240_table % 32u) != 0u) { return 1; }\n"
        "    return fwrite(perkins240_table, perkins240_table_size, 1, stdout) == 1u ? 0 : 2;\n}\n"
    )
    sources = ["main.c", "perkins240_table.c"]
    command = [compiler, *STRICT_C, *sources, "-o", "show"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    shown = subprocess.run([tmp_path / "show"], capture_output=True, check=True).stdout
    assert shown == (tmp_path / "perkins240.camtab").read_bytes()


@pytest.mark.parametrize("name", ["16V240-ZJ", "int", "a-b", "9"])
def test_every_part_name_makes_valid_c(tmp_path: Path, name: str) -> None:
    """Digits first, hyphens and keywords still give sources that compile."""
    assert identifier(name).isidentifier()
    (tmp_path / f"{name}_table.h").write_text(emit_header(name, 32))
    (tmp_path / f"{name}_table.c").write_text(emit_source(name, bytes(range(32))))
    command = ["gcc", *STRICT_C, "-c", f"./{name}_table.c", "-o", "out.o"]
    built = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")


def test_full_disk_leaves_the_old_set(mktables: Command, tmp_path: Path) -> None:
    """When writing fails half-way, older files are as they were and nothing is added."""
    for name in NAMES:
        (tmp_path / name).write_text("older")
    run = mktables(PERKINS, "-o", tmp_path, largest_file=8192)
    assert run.returncode == 2
    assert "cannot write: File too large; " in run.stderr
    assert run.stderr.count("\n") == 1
    assert listing(tmp_path) == NAMES
    assert {path.read_text() for path in tmp_path.iterdir()} == {"older"}


@pytest.mark.parametrize("target", ["missing", "older", "pipe", "folder", "circle"])
def test_symbolic_links_stay(tmp_path: Path, target: str) -> None:
    """The file that a link points to is replaced, in its own folder; nothing else ever is."""
    there, here = tmp_path / "there", tmp_path / "here"
    (there / "folder").mkdir(parents=True)
    (there / "older").write_text("older")
    os.mkfifo(there / "pipe")
    (there / "circle").symlink_to("circle")
    here.mkdir()
    (here / "b").symlink_to(Path("..") / "there" / target)
    before = listing(there)
    if target in ("missing", "older"):
        write_all(here, {"a": b"new", "b": b"new"})
        assert (there / target).read_bytes() == b"new"
        assert listing(there) == sorted({*before, target})
    else:
        with pytest.raises(CamtoolsError, match=r"^\S*: cannot write: [^;]*; give "):
            write_all(here, {"a": b"new", "b": b"new"})
        assert (listing(here), listing(there)) == (["b"], before)
    assert (here / "b").is_symlink()
    assert (there / "pipe").is_fifo()


def test_interrupted_run_leaves_nothing(
    mktables: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A signal while writing removes temporaries and the new folder; the status tells it."""

    def interrupt(_file: int) -> None:
        assert any(name.endswith(".tmp") for name in listing(tmp_path / "out"))
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("camtools.base.files.os.fsync", interrupt)
    done = mktables(PERKINS, "-o", tmp_path / "out")
    assert done.returncode == 128 + signal.SIGINT
    assert done.stderr == "mktables: interrupted; nothing was written\n"
    assert listing(tmp_path) == []


def _interrupted_import(folder: Path, *words: str) -> tuple[int, str]:
    """Return status and complaint of a Python that is interrupted while it imports numpy."""
    (folder / "numpy.py").write_text("import time\nprint('here', flush=True)\ntime.sleep(30)\n")
    env = environment()
    env["PYTHONPATH"] = f"{folder}:{env['PYTHONPATH']}"
    with subprocess.Popen(
        [sys.executable, *words],
        env=env,
        # A shell's background jobs ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as run:
        assert run.stdout is not None
        assert run.stdout.readline() == "here\n"
        run.send_signal(signal.SIGINT)
        _, err = run.communicate()
    return run.returncode, err


def test_interrupted_loading_is_silent(tmp_path: Path) -> None:
    """Ctrl-C before a tool has its handlers ends it without a traceback."""
    status, err = _interrupted_import(tmp_path, "-m", "camtools.cli.mktables", "--help")
    assert (status, err) == (-signal.SIGINT, "")


def test_library_leaves_the_interrupt_alone(tmp_path: Path) -> None:
    """Whoever imports the package gets KeyboardInterrupt as ever."""
    _, err = _interrupted_import(tmp_path, "-c", "import camtools.cli.mktables")
    assert err.endswith("KeyboardInterrupt\n")
