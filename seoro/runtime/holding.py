"""What instances hold: the structs and actors in their fields, and in the fields of these."""

from __future__ import annotations

from collections.abc import Iterator, MutableSet

from seoro.runtime.values import Actor, HasFields, Struct, Value


def newly_held(instance: HasFields, seen: MutableSet[Struct | Actor]) -> Iterator[tuple[Struct | Actor, str]]:
    """The structs and actors that an instance holds and none has held before, with their paths.

    Args:
        instance: The instance.
        seen: What others have held; what is found is added.
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
