"""Leases by hand of robots of two bridges: all are had, or none is kept, whatever goes wrong in between."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from typing import Any

import anyio
import pytest

from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.client.lab import LabControl
from seoro.errors import BackendError, BackendLost
from seoro.lab import commanding
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
    """Has nodes asked in another way."""
    return lambda asks: monkeypatch.setattr(commanding, "ask", asks)


def losing(*verbs: str) -> Asking:
    """Asks, and loses answers; of those to leases, that of the second bridge."""

    async def asks(address: NodeAddress, verb: Any, request: Any, timeout: float) -> Any:
        answer = await ask(address, verb, request, timeout)
        if verb.name in verbs and getattr(request, "robots", ()) != ("line",):
            raise BackendLost(LOST)
        return answer

    return asks


async def leases(there: LabControl) -> list[str]:
    """The ids of leases that robots are under."""
    states = [member.state for member in await there.status()]
    assert None not in states
    return [robot.lease.lease for state in states if state for robot in state.robots if robot.lease]


async def test_nothing_is_kept_where_an_answer_is_lost(
    there: LabControl, asking_by: Callable[[Asking], None]
) -> None:
    asking_by(losing("lease_robots"))
    with pytest.raises(BackendError, match=f"^cannot lease line, second: the node 'rails': {LOST}$"):
        await there.lease("line", "second")
    assert await leases(there) == []


async def test_it_is_said_where_a_lease_may_be_kept(
    there: LabControl, asking_by: Callable[[Asking], None]
) -> None:
    asking_by(losing("lease_robots", "release_lease"))
    ends = "if it keeps robots all the same, `seoro lab release hand-.*` ends that"
    words = f"'rails': it does not answer any more; {ends}; the node 'rails': {LOST}; {ends}"
    with pytest.raises(BackendError, match=words):
        await there.lease("line", "second")


async def test_nothing_is_kept_where_leasing_is_cancelled(
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
