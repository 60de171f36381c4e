"""Emissions in a run, kept by its executor."""

from __future__ import annotations

import asyncio

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire import decode
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.runs.active_run import KEPT, MOST_PENDING, Emissions


def request(number: int, size: int = 0, wait: float = 0.0) -> wire.EmitEvent:
    fields = b'{"text": "' + b"x" * size + b'"}'
    return wire.EmitEvent(run="a" * 32, emission=f"{number:032x}", event="go", fields=fields, wait=wait)


async def test_a_pending_emission_may_be_requested_again() -> None:
    emissions, sent = Emissions(), list[bytes]()
    assert (await emissions.emit(request(1), sent.append)).time is None
    emissions.conclude(wire.Emitted(emission=request(1).emission, time=2.0, name="main.go"))
    assert (await emissions.emit(request(1), sent.append)).time == 2.0
    assert [decode(wire.EmitEvent, data).event for data in sent] == ["go"]


async def test_emissions_refused_by_the_run_are_refused() -> None:
    emissions = Emissions()
    waiting = asyncio.create_task(emissions.emit(request(1, wait=5.0), lambda data: None))
    await asyncio.sleep(0)
    emissions.conclude(wire.Emitted(emission=request(1).emission, refused="unknown event"))
    with pytest.raises(RequestRefused, match="unknown event") as caught:
        await waiting
    assert caught.value.code == wire.NOT_EMITTED


async def test_the_end_of_a_run_refuses_pending_emissions() -> None:
    emissions = Emissions()
    waiting = asyncio.create_task(emissions.emit(request(1, wait=5.0), lambda data: None))
    await asyncio.sleep(0)
    emissions.end()
    with pytest.raises(RequestRefused, match="the run is over"):
        await waiting


async def test_the_number_of_pending_emissions_is_limited() -> None:
    emissions, sent = Emissions(), list[bytes]()
    with pytest.raises(RequestRefused, match="try again later") as caught:
        for number in range(100):
            await emissions.emit(request(number, 4000), sent.append)
    assert caught.value.code == wire.UNAVAILABLE
    assert 0 < sum(map(len, sent)) <= MOST_PENDING
    emissions.conclude(wire.Emitted(emission=request(0).emission, time=0.0))
    await emissions.emit(request(100), sent.append)


async def test_old_answers_of_emissions_are_dropped() -> None:
    emissions, sent = Emissions(), list[bytes]()
    for number in range(KEPT + 10):
        await emissions.emit(request(number), sent.append)
        emissions.conclude(wire.Emitted(emission=request(number).emission, time=0.0))
    assert (await emissions.emit(request(20), sent.append)).time == 0.0
    assert len(sent) == KEPT + 10
    await emissions.emit(request(0), sent.append)
    assert len(sent) == KEPT + 11
