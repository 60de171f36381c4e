"""Verbs that executors serve, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from seoro.bridges.executor import messages
from seoro.bridges.executor.probing import PROBE
from seoro.bridges.wire.authentication import CHALLENGE, CLAIM
from seoro.bridges.wire.lab import EMERGENCY_STOP, RELEASE_STOP
from seoro.bridges.wire.message import Verb

_OWN: Final = tuple(value for value in vars(messages).values() if isinstance(value, Verb))
EXECUTOR_VERBS: Final[Mapping[str, Verb[Any, Any]]] = MappingProxyType(
    {verb.name: verb for verb in (*_OWN, PROBE, CHALLENGE, CLAIM, EMERGENCY_STOP, RELEASE_STOP)}
)
