"""Command line: the same sources, built in another folder, give the same image as in build/PRESET.

>>> difference(b"same bytes", b"same bytes") is None
True
>>> difference(b"same bytes", b"same byte")
'9 of 10 and 9 bytes agree, then they differ'
"""

from __future__ import annotations

import hashlib
import itertools
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT

FAILED = 1


def difference(left: bytes, right: bytes) -> str | None:
    """Return where two images differ, if they do."""
    if left == right:
        return None
    same = itertools.takewhile(lambda pair: pair[0] == pair[1], zip(left, right, strict=False))
    n_same = sum(1 for _ in same)
    return f"{n_same} of {len(left)} and {len(right)} bytes agree, then they differ"


def other_folder(temporary: Path, root: Path = ROOT) -> Path:
    """Return a folder whose path is of another length, so that a path in the image moves bytes.

    >>> str(other_folder(Path("/tmp"), Path("/home/root")))
    '/tmp/place_'
    >>> str(other_folder(Path("/tmp"), Path("/root")))
    '/tmp/place'
    """
    folder = temporary / "place"
    return folder if len(str(folder)) != len(str(root)) else temporary / "place_"


def _copy(unity: Path, folder: Path) -> None:
    """Copy sources and Unity to where a build looks for them."""

    def not_sources(inside: str, names: list[str]) -> set[str]:
        builds = {"build"} if Path(inside) == ROOT else set()
        return builds | {name for name in names if name.startswith(".git")}

    shutil.copytree(ROOT, folder, ignore=not_sources, symlinks=True)
    shutil.copytree(unity, folder / "build" / "_unity")


def _run(*words: str, folder: Path) -> None:
    done = subprocess.run(
        words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode:
        raise CamtoolsError([*done.stdout.splitlines()[-20:], f"{words[0]} failed"])


def build(preset: str, target: str, folder: Path) -> bytes:
    """Return the image of a target, built from the sources in a folder."""
    _run("cmake", "--preset", preset, folder=folder)
    _run("cmake", "--build", "--preset", preset, "-j2", "--target", target, folder=folder)
    images = [path for path in (folder / "build" / preset).rglob(target) if path.is_file()]
    if len(images) != 1:
        raise CamtoolsError([f"{target}: {len(images)} programs; name one program as target"])
    return images[0].read_bytes()


def check(preset: str, target: str, unity: Path) -> int:
    """Build here and elsewhere and compare; 0 if every byte is the same, debug information too."""
    if not unity.is_dir():
        raise CamtoolsError([f"{unity}: not there; build a preset first, or name it with --unity"])
    with tempfile.TemporaryDirectory(prefix="camturn_") as temporary:
        folder = other_folder(Path(temporary))
        _copy(unity, folder)
        images = [build(preset, target, ROOT), build(preset, target, folder)]
    for image in images:
        print(f"{hashlib.sha256(image).hexdigest()} {len(image)} bytes")
    found = difference(*images)
    if found:
        print(f"FAILED: {preset} {target}: {found}")
    return FAILED if found else 0


def main(argv: list[str] | None = None) -> int:
    """Compare two builds; 0 the same, 1 not, 2 a build fails."""
    parser = Parser(prog="same_bytes", description="Build here and in another folder; compare.")
    parser.add_argument("preset")
    parser.add_argument("target")
    parser.add_argument("--unity", type=Path, default=ROOT / "build" / "_unity", metavar="DIR")
    words = parser.parse_args(argv)
    return run_command("same_bytes", lambda: check(words.preset, words.target, words.unity))


if __name__ == "__main__":
    sys.exit(main())
