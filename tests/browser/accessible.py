"""What axe finds wrong with a page for people who see, hear or move otherwise; what all read."""

import re

from axe_playwright_python.base import AXE_SCRIPT
from playwright.sync_api import Page

_GRAVE = ("serious", "critical")
# Animations stand still meanwhile: one of them tells of a page that gets no news, and it gets none
# while axe runs.
_RUN = """async () => {
    const still = new CSSStyleSheet();
    still.replaceSync("* { animation: none !important; transition: none !important }");
    document.adoptedStyleSheets.push(still);
    const found = await axe.run(document, {resultTypes: ["violations"]});
    document.adoptedStyleSheets.pop();
    return found.violations;
}"""


def grave_findings(page: Page) -> list[str]:
    """Return the serious and critical findings of every rule, with the elements they are of."""
    if not page.evaluate("typeof axe === 'object'"):
        page.evaluate(AXE_SCRIPT)
    found = page.evaluate(_RUN)
    return [
        f"{rule['id']} ({rule['impact']}): {rule['help']}: {node['html'][:200]}"
        for rule in found
        if rule["impact"] in _GRAVE
        for node in rule["nodes"]
    ]


def told_um(text: str) -> float:
    """Return the first length of a text, as a person reads it [um]."""
    found = re.search(r"([\d.]+) (nm|um|\N{MICRO SIGN}m)", text)
    assert found is not None, text
    return float(found[1]) * (1e-3 if found[2] == "nm" else 1.0)
