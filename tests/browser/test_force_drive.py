"""The loop of a U that takes forces is measured and set in the browser."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.accessible import grave_findings
from tests.browser.conftest import Keep
from tests.browser.panel_page import command, give, order
from tests.browser.panel_session import PanelSession, panel_session, weak_machine
from tests.browser.windows import OpenWindow

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def force_session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PanelSession]:
    """Run a lathe whose U takes forces, and its panel."""
    folder = tmp_path_factory.mktemp("force")
    with panel_session(folder, ("--machine", weak_machine(folder))) as one:
        yield one


def test_a_loop_is_measured_and_applied(
    force_session: PanelSession, open_window: OpenWindow, keep: Keep
) -> None:
    """Measure is on in ready, Apply after it; the card shows report and picture."""
    page = open_window().page
    command(page, force_session)
    card, apply = page.get_by_test_id("card-drive"), order(page, "apply_loop")
    expect(page.get_by_test_id("drive-loop")).to_contain_text("crossover 60 Hz")
    expect(order(page, "measure_loop")).to_be_disabled()
    give(page, force_session, "enable", "ready")
    expect(order(page, "measure_loop")).to_be_enabled()
    expect(apply).to_be_disabled()
    give(page, force_session, "measure_loop", "ready")
    expect(apply).to_be_enabled()
    expect(page.get_by_test_id("drive-report")).to_contain_text("as it is (measured): crossover")
    picture = page.get_by_test_id("drive-picture")
    expect(picture).to_be_visible()
    assert picture.evaluate("img => img.decode().then(() => img.naturalWidth)") > 500
    card.scroll_into_view_if_needed()
    keep(page, "Operate, drive of U", is_whole=True)
    assert not grave_findings(page)
    give(page, force_session, "apply_loop", "off")
    expect(page.get_by_test_id("last-order")).to_contain_text("parameters are set")
    expect(page.get_by_test_id("drive-loop")).not_to_contain_text("crossover 60 Hz")
    expect(apply).to_be_disabled()
