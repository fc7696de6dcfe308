# SPDX-License-Identifier: Apache-2.0
"""Take the picture of tools/docs/DESIGN.md from a panel that runs.

Start `tools/panel --port 8611` in another terminal and give this script the address that it prints.
"""

import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

DOCS = Path(__file__).resolve().parents[2] / "tools" / "docs"
_WORDS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]


def main(url: str) -> None:
    """Take the picture when the preview is that of the text."""
    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            tempfile.mkdtemp(),
            executable_path="/usr/bin/chromium",
            args=_WORDS,
            viewport={"width": 1400, "height": 1180},
        )
        page = context.new_page()
        page.goto(url.replace("/#", "/design#"))
        page.get_by_text("preview of this text").wait_for(timeout=60_000)
        page.wait_for_timeout(1000)
        page.screenshot(path=str(DOCS / "design_page.png"))
        context.close()


if __name__ == "__main__":
    main(sys.argv[1])
