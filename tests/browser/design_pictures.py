# SPDX-License-Identifier: Apache-2.0
"""Take the pictures of tools/docs/DESIGN.md from a panel that runs.

    tools/panel --port 8611 --token-file FILE    # in another terminal
    build/venv/bin/python tests/browser/design_pictures.py 'http://127.0.0.1:8611/#token=..'

It cuts the Perkins skirt three times: on the machine of the part, and on `real` with learning and
without, and compares those two, and the first with the second.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

DOCS = Path(__file__).resolve().parents[2] / "tools" / "docs"
_CUT_MS = 300_000
_WORDS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]


def choose(page: Page, mark: str, text: str) -> None:
    """Choose an entry of a list."""
    page.locator(f"[data-testid={mark}]").first.click()
    page.locator(".q-menu .q-item").get_by_text(text, exact=True).first.click()


def settled(page: Page) -> None:
    """Wait until the preview is that of the text."""
    page.get_by_text("preview of this text").wait_for(timeout=60_000)
    page.wait_for_timeout(1000)


def cut(page: Page, machine: str, *, learns: bool) -> None:
    """Cut the part and wait for its report."""
    if machine:
        choose(page, "cut-machine", machine)
    if not learns:
        page.locator("[data-testid=cut-learns]").click()
    page.locator("[data-testid=cut]").click()
    page.wait_for_timeout(2000)
    state = page.locator("[data-testid=cut-state]")
    for _ in range(_CUT_MS // 1000):
        if "tolerance" in (state.text_content() or ""):
            return
        page.wait_for_timeout(1000)
    raise RuntimeError(state.text_content())


def compared(page: Page, url: str, rows: tuple[int, int], file: str) -> None:
    """Take the picture of two runs side by side; the newest run is row 0."""
    page.goto("about:blank")  # else a page that is open stays, with what was picked
    page.goto(url.replace("/#", "/runs#"))
    boxes = page.locator("[data-testid=runs-table] tbody .q-checkbox")
    boxes.nth(max(rows)).wait_for(timeout=30_000)
    for row in rows:
        boxes.nth(row).click()
    page.locator("[data-testid=compare]").click()
    page.locator("[data-testid=error-map-1]").wait_for(timeout=60_000)
    page.wait_for_timeout(1500)
    place = page.locator("[data-testid=comparison]").bounding_box()
    end = page.locator("[data-testid=error-map-1]").bounding_box()
    assert place is not None
    assert end is not None
    clip = {**place, "height": end["y"] + end["height"] - place["y"]}
    page.screenshot(path=str(DOCS / file), full_page=True, clip=clip)  # type: ignore[arg-type]


def main(url: str) -> None:
    """Take all pictures."""
    with sync_playwright() as playwright:
        context = playwright.chromium.launch_persistent_context(
            tempfile.mkdtemp(),
            executable_path="/usr/bin/chromium",
            args=_WORDS,
            viewport={"width": 1400, "height": 1180},
        )
        page = context.new_page()
        page.goto(url.replace("/#", "/design#"))
        settled(page)
        page.screenshot(path=str(DOCS / "design_page.png"))
        page.locator("[data-testid=tab-form]").click()
        page.wait_for_timeout(800)
        field = page.locator("[data-testid='field-machine.limits.u_speed_mm_s']").first
        field.click()
        page.keyboard.press("Control+A")
        page.keyboard.type("20")
        page.get_by_text("not feasible").wait_for(timeout=60_000)
        page.wait_for_timeout(1500)
        page.screenshot(path=str(DOCS / "design_form.png"))
        page.locator("[data-testid=undo]").click()
        settled(page)
        cut(page, "", learns=True)
        cut(page, "real", learns=True)
        cut(page, "", learns=False)
        compared(page, url, (1, 2), "design_machines.png")
        compared(page, url, (0, 1), "design_learning.png")
        context.close()


if __name__ == "__main__":
    main(sys.argv[1])
