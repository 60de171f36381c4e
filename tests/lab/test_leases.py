"""Manual leases of robots of two bridges: all or none, also after failures in between."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import anyio
import pytest

from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.client.lab import LabControl
from seoro.errors import BackendError, BackendLost
from seoro.lab import commands, outcomes
from tests.bridges.robot.conftest import Rails, rails_at

pytestmark = pytest.mark.anyio

LOST = "the answer is lost"
Asking = Callable[..., Awaitable[Any]]


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rails]:
    folder = tmp_path_factory.mktemp("other")
    with rails_at(folder, "--listen", f"unixsock-stream/{folder}/rails", "second") as running:
        yield running


@pytest.fixture
def there(rails: Rails, other: Rails) -> LabControl:
    return LabControl([rails.endpoint, other.endpoint])


@pytest.fixture
def asking_by(monkeypatch: pytest.MonkeyPatch) -> Callable[[Asking], None]:
    """Return a function that replaces the requests to nodes."""

    def replace(asks: Asking) -> None:
        for module in (commands, outcomes):
            monkeypatch.setattr(module, "ask", asks)

    return replace


def losing(*verbs: str) -> Asking:
    """Return a request function that loses answers; for leases, that of the second bridge."""

    async def asks(address: NodeAddress, verb: Any, request: Any, timeout: float) -> Any:
        answer = await ask(address, verb, request, timeout)
        if verb.name in verbs and getattr(request, "robots", ()) != ("line",):
            raise BackendLost(LOST)
        return answer

    return asks


async def leases(there: LabControl) -> list[str]:
    """Return the ids of leases of robots."""
    states = [member.state for member in await there.status()]
    assert None not in states
    return [robot.lease.lease for state in states if state for robot in state.robots if robot.lease]


async def test_no_lease_remains_after_a_lost_answer(
    there: LabControl, asking_by: Callable[[Asking], None]
) -> None:
    asking_by(losing("lease_robots"))
    with pytest.raises(BackendError, match=f"^cannot lease line, second: the node 'rails': {LOST}$"):
        await there.lease("line", "second")
    assert await leases(there) == []


async def test_nodes_that_may_keep_a_lease_are_reported(
    there: LabControl, asking_by: Callable[[Asking], None]
) -> None:
    asking_by(losing("lease_robots", "release_lease"))
    ends = "if it still holds robots, release them by `seoro lab release hand-.*`"
    words = f"'rails': it no longer answers; {ends}; the node 'rails': {LOST}; {ends}"
    with pytest.raises(BackendError, match=words):
        await there.lease("line", "second")


async def test_no_lease_remains_after_a_cancelled_request(
    there: LabControl, asking_by: Callable[[Asking], None]
) -> None:
    released: list[str] = []

    async def asks(address: NodeAddress, verb: Any, request: Any, timeout: float) -> Any:
        answer = await ask(address, verb, request, timeout)
        if verb.name == "lease_robots" and request.robots == ("second",):
            scope.cancel()
            await anyio.sleep_forever()
        if verb.name == "release_lease":
            released.append(address.node)
        return answer

    asking_by(asks)
    with anyio.CancelScope() as scope:
        await there.lease("line", "second")
    assert scope.cancelled_caught
    assert released == ["rails", "rails"]
    assert await leases(there) == []
