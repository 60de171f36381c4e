"""Verbs of the protocol, from their declarations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from seoro.bridges import wire
from seoro.bridges.executor.verbs import EXECUTOR_VERBS
from seoro.bridges.wire.message import Verb
from tests.tools.reference.tables import code, table


def node_verbs() -> str:
    """Return a table of the verbs that simulators and bridges serve."""
    return _table(wire.NODE_VERBS.values())


def executor_verbs() -> str:
    """Return a table of the verbs that executors serve."""
    return _table(EXECUTOR_VERBS.values())


def result_codes() -> str:
    """Return a table of the result codes of refusals."""
    families = (
        (wire.Result, "all"),
        (wire.SpawnResult, "spawning"),
        (wire.StateResult, "`set_simulation_state`"),
        (wire.WorldResult, "`load_world`, `unload_world`"),
        (wire.LabResult, "holds of robots, the node"),
    )
    rows = [(str(code.value), code.name, where) for family, where in families for code in family]
    return table(("code", "name", "verbs"), rows)


def _table(verbs: Iterable[Verb[Any, Any]]) -> str:
    rows = [
        (
            code(verb.name),
            _fields(verb.request),
            _fields(verb.reply),
            verb.role.value,
            f"{verb.limits.size // 1024} KiB",
        )
        for verb in sorted(verbs, key=lambda verb: verb.name)
    ]
    return table(("verb", "request", "reply", "lowest role", "largest request"), rows)


def _fields(model: Any) -> str:
    return ", ".join(code(name) for name in model.model_fields) or "-"
