"""Take the picture of tools/docs/DESIGN.md from a panel that runs.

Start `tools/panel --port 8611` in another terminal and give this module the address that it prints.
"""

import sys
from pathlib import Path

from tests.browser.windows import chromium

DOCS = Path(__file__).resolve().parents[2] / "tools" / "docs"


def main(url: str) -> None:
    """Take the picture when the preview is that of the text."""
    with chromium() as browser, browser.window(viewport={"width": 1400, "height": 1180}) as window:
        window.page.goto(url + "design")
        window.page.get_by_text("preview of this text").wait_for()
        window.page.wait_for_timeout(1000)
        window.page.screenshot(path=DOCS / "design_page.png")


if __name__ == "__main__":
    main(sys.argv[1])
