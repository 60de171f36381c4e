"""What carries out a verb: a function of a simulator and a request, which returns the answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from seoro.bridges.wire import Message, Verb
from sim_nodes.simulator import Simulator

Handler = Callable[[Simulator, Any], Message]
Handling = tuple[Verb[Any, Any], Handler]
