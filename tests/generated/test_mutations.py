"""The independent checker of traces finds faults of the runtime, without false alarms."""

from __future__ import annotations

import asyncio
from textwrap import indent

import pytest

from seoro.runtime.accept import Acceptance, check_trace
from tests.generated.model import HEADER
from tests.generated.mutations import MUTATIONS, Mutation
from tests.generated.running import execute, load_text


def acceptance(mutation: Mutation) -> Acceptance:
    """Return the violations in the trace of the mutation's scenario."""
    body = indent(mutation.body, " " * 12)
    text = f"""scenario worker inherits base:
    pace: time = 1s
    do wait elapsed(pace)
scenario main inherits base:
{indent(mutation.members, " " * 4)}
    do parallel:
        serial:
{body}
        serial:
            wait elapsed(1s)
            emit one
            wait elapsed(3s)
"""
    loaded = load_text(HEADER + text)
    return check_trace(loaded.plan, asyncio.run(asyncio.wait_for(execute(loaded), 30.0)).records)


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda mutation: mutation.name.replace(" ", "_"))
def test_a_fault_of_the_runtime_is_found(mutation: Mutation, monkeypatch: pytest.MonkeyPatch) -> None:
    sound = acceptance(mutation)
    assert sound.accepted, sound.violations
    mutation.put_in(monkeypatch)
    assert not acceptance(mutation).accepted
