# SPDX-License-Identifier: Apache-2.0
"""Pictures of pages for people to look at, in build/reports/browser with an index.html.

>>> name_of("Report of a skirt, dark")
'report-of-a-skirt-dark'
"""

import html
import re
import shutil
from pathlib import Path

from playwright.sync_api import Page

from tests.tools.cases.part_cases import ROOT

FOLDER = ROOT / "build" / "reports" / "browser"
_PAGE = """\
<!doctype html><html lang="en"><meta charset="utf-8"><title>Pages in the browser</title>
<style>body {{ font: 1rem sans-serif; margin: 1rem }} figure {{ margin: 0 0 2rem }}
img {{ max-width: 100%; border: 1px solid gray }}</style>
<h1>Pages in the browser</h1>
{figures}
</html>
"""
_FIGURE = '<figure><figcaption>{text}</figcaption><img src="{name}.png" alt="{text}"></figure>'


def name_of(text: str) -> str:
    """Return a caption as the name of a file."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")


class Gallery:
    """The pictures of a run of the tests; those of the run before are gone."""

    def __init__(self, folder: Path = FOLDER) -> None:
        self.folder = folder
        self._captions: list[str] = []
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)

    def keep(self, page: Page, text: str, *, is_whole: bool = False) -> None:
        """Take a picture of what is seen, or of the whole page, and give it a caption."""
        path = self.folder / f"{name_of(text)}.png"
        assert not path.exists(), f"two pictures are called {text!r}"
        if is_whole:
            page.evaluate("scrollTo(0, 0)")  # else what stays in sight lies over the middle
        page.screenshot(path=path, full_page=is_whole, animations="disabled")
        self._captions.append(text)

    def write_index(self) -> None:
        """Write the page with all pictures."""
        names = ((html.escape(text), name_of(text)) for text in self._captions)
        figures = "\n".join(_FIGURE.format(text=text, name=name) for text, name in names)
        (self.folder / "index.html").write_text(_PAGE.format(figures=figures), "utf-8")
