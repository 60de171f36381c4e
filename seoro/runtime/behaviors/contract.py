"""Types of functions that run behaviors."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Coroutine
from typing import Any, TypeAlias

from seoro.lang.plan import Behavior
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.kernel.task import Task
from seoro.runtime.verdict import Outcome

Perform: TypeAlias = Callable[[Behavior, ExecutionContext], Awaitable[Outcome]]
"""Runs a behavior."""

PerformMember: TypeAlias = Callable[[Task, Behavior, int, ExecutionContext], Coroutine[Any, Any, Outcome]]
"""Runs a member of a composition in a task of its own, given its index and the composition's context."""

Carry: TypeAlias = Callable[[ExecutionContext], Awaitable[Outcome]]
"""Runs a certain behavior in a context."""
