"""What the commands of generated pages share: compare with the source, or write.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     page_command("demo", None, Path(name), lambda: {"a.txt": "text"}, ["--write"])
0
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all


def page_command(
    name: str,
    description: str | None,
    folder: Path,
    pages: Callable[[], Mapping[str, str]],
    words: list[str] | None,
) -> int:
    """Run the command checks.NAME; return its exit status.

    `pages` returns the text of each page by its path in the folder; --write writes them. Returns 0;
    2 when a page differs from its source, or the source is wrong.
    """
    parser = Parser(prog=f"checks.{name}", description=description)
    parser.add_argument("--write", action="store_true", help="write the pages")
    options = parser.parse_args(words)

    def act() -> int:
        texts = pages()
        if options.write:
            write_all(folder, {path: text.encode("utf-8") for path, text in texts.items()})
        for path, text in texts.items():
            file = folder / path
            if not file.is_file() or file.read_text("utf-8") != text:
                raise CamtoolsError([f"{path}: differs from its source; use --write"])
        return 0

    return run_command(name, act)
