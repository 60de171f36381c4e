"""Objects held by instances: structs and actors in their fields, and in fields of these."""

from __future__ import annotations

from collections.abc import Iterator, MutableSet

from seoro.runtime.values.values import Actor, HasFields, Struct, Value


def newly_held(instance: HasFields, seen: MutableSet[Struct | Actor]) -> Iterator[tuple[Struct | Actor, str]]:
    """Yield the objects that an instance is the first to hold, with their paths.

    Args:
        instance: The instance.
        seen: Objects held before; found ones are added.
    """
    pending: list[tuple[str, Value]] = list(instance.fields.items())
    while pending:
        path, value = pending.pop(0)
        if isinstance(value, tuple):
            pending[:0] = [(f"{path}[{number}]", part) for number, part in enumerate(value)]
        elif isinstance(value, Struct | Actor) and value not in seen:
            seen.add(value)
            yield value, path
            pending[:0] = [(f"{path}.{name}", part) for name, part in value.fields.items()]
