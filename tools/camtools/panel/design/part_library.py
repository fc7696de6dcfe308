"""Part files to work on: the examples, a folder of one's own, and the text with undo and redo.

Names are checked, files are replaced only when that was said, and all of a file is written or none.

>>> draft = Draft("a")
>>> draft.change("ab", at_s=0.0); draft.change("abc", at_s=0.1); draft.change("x", at_s=5.0)
>>> draft.undo(), draft.undo(), draft.redo()
('abc', 'a', 'abc')
"""

import re
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.base.files import read_limited, utf8_text, write_all
from camtools.base.project import ROOT
from camtools.part.model import MAX_FILE_BYTES

EXAMPLES = ROOT / "tools" / "parts"
EXAMPLE, OWN = "example", "own"
MOST_PARTS = 1000
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,30}\Z")
FILE_ENDS = (".csv", ".dxf")
_FILE_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,60}\.(csv|dxf)\Z")
_MAX_FILE_BYTES = 20_000_000


def checked_name(name: str) -> str:
    """Return a name that is good for a file, or raise CamtoolsError."""
    if not _NAME.match(name):
        shown = name if len(name) <= 40 else name[:37] + "..."
        problem = f"name {shown!r}: not usable"
        remedy = "use 1 to 31 letters, digits, _ and -, a letter or digit first"
        raise CamtoolsError([f"{problem}; {remedy}"])
    return name


class PartLibrary:
    """Part files: the examples, and a folder of one's own, made when something is saved."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def folder(self, source: str) -> Path:
        """Return the folder in which the files lie that a part of this source names."""
        return EXAMPLES if source == EXAMPLE else self._folder

    def examples(self) -> list[str]:
        """Return the names of the project's examples."""
        return sorted(path.stem for path in EXAMPLES.glob("*.toml"))

    def own(self) -> list[str]:
        """Return the names of one's own parts."""
        return sorted(
            path.stem
            for path in self._folder.glob("*.toml")
            if _NAME.match(path.stem) and not path.is_symlink()
        )

    def has(self, name: str) -> bool:
        """Return whether there is a part of one's own of that name."""
        return (self._folder / f"{checked_name(name)}.toml").exists()

    def read(self, source: str, name: str) -> str:
        """Return the text of a part; raise CamtoolsError where it cannot be read."""
        path = self.folder(source) / f"{checked_name(name)}.toml"
        try:
            if path.is_symlink():
                raise OSError(0, "is a link")
            data = read_limited(path, MAX_FILE_BYTES)
        except OSError as error:
            problem = f"{name}: cannot be read: {error.strerror}"
            raise CamtoolsError([f"{problem}; choose another"]) from error
        return utf8_text(data, name)

    def save(self, name: str, text: str, *, replaces: bool) -> None:
        """Write a part of one's own; a part of that name is replaced only where it shall be."""
        checked_name(name)
        if self.has(name) and not replaces:
            raise CamtoolsError([f"{name}: this part exists; give another name or replace it"])
        data = text.encode("utf-8", "replace")
        if len(data) > MAX_FILE_BYTES:
            problem = f"{name}: {len(data)} bytes, a part file has at most {MAX_FILE_BYTES}"
            raise CamtoolsError([f"{problem}; put long lists into a CSV file"])
        self._write(f"{name}.toml", data)

    def save_file(self, name: str, data: bytes, *, replaces: bool) -> None:
        """Write a CSV or DXF file that parts of one's own may name; errors as `save`."""
        if not _FILE_NAME.match(name):
            remedy = "use letters, digits, _, - and ., and the ending .csv or .dxf"
            raise CamtoolsError([f"name {name[:40]!r}: not usable; {remedy}"])
        if len(data) > _MAX_FILE_BYTES:
            raise CamtoolsError([f"{name}: more than {_MAX_FILE_BYTES} bytes; give fewer points"])
        if (self._folder / name).exists() and not replaces:
            raise CamtoolsError([f"{name}: this file exists; give another name or replace it"])
        self._write(name, data)

    def _write(self, name: str, data: bytes) -> None:
        if len(list(self._folder.glob("*"))) >= MOST_PARTS:
            raise CamtoolsError([f"the library has {MOST_PARTS} files; remove some"])
        if (self._folder / name).is_symlink():
            raise CamtoolsError([f"{name}: is a link; give another name"])
        write_all(self._folder, {name: data})


_TOGETHER_S = 0.8  # what is typed without a rest is undone together
_MOST_STEPS = 200


class Draft:
    """A text with its history."""

    def __init__(self, text: str) -> None:
        self.text = text
        self._before: list[str] = []
        self._undone: list[str] = []
        self._changed_s = -1e9

    def change(self, text: str, at_s: float, *, is_step: bool = False) -> None:
        """Take a text that changed at a time [s]; a step of its own is undone alone."""
        if text == self.text:
            return
        if is_step or not self._before or at_s - self._changed_s > _TOGETHER_S:
            self._before.append(self.text)
            del self._before[:-_MOST_STEPS]
        self._changed_s = -1e9 if is_step else at_s
        self._undone.clear()
        self.text = text

    def undo(self) -> str:
        """Return the text before the last change."""
        return self._moved(self._before, self._undone)

    def redo(self) -> str:
        """Return the text that was undone last."""
        return self._moved(self._undone, self._before)

    def _moved(self, source: list[str], target: list[str]) -> str:
        if source:
            target.append(self.text)
            self.text, self._changed_s = source.pop(), -1e9
        return self.text
