"""A service before a fresh controller."""

from collections.abc import Iterator

import pytest

from tests.tools.cases.camctl_bench import Bench
from tests.tools.cases.controller_cases import Seat


@pytest.fixture(scope="module")
def shared_bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return a controller for a whole module."""
    one = Bench(request.node.name)
    yield one
    one.close()


@pytest.fixture(scope="module")
def shared_seat(shared_bench: Bench) -> Iterator[Seat]:
    """Return a service before it."""
    one = Seat(shared_bench.channel)
    one.connect()
    yield one
    one.service.close()


@pytest.fixture
def seat(shared_seat: Seat) -> Seat:
    """Return the service with the boss in command and the controller off."""
    seat = shared_seat
    seat.commander.take_over(seat.boss)
    for visitor in (seat.boss, seat.other):
        visitor.is_here, visitor.was_connected, visitor.back_at_s = True, False, -1e9
    if seat.state not in ("off", "ready"):
        seat.ask("stop")
    if seat.state != "off":
        seat.ask("disable")
    seat.wait_for("off")
    return seat
