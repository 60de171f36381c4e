"""Types whose values would contain themselves without end, by their fields or by constructed defaults.

Fields that hold actors are exempt: constraints may refer them to existing actors.
"""

from __future__ import annotations

from collections.abc import Iterator

from seoro.lang import plan
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import behaviors as messages


def check_containment(structures: plan.Structures, bag: Bag) -> None:
    """Report each cycle of types that contain one another, once."""
    done: set[str] = set()
    for structure in sorted(structures.all(), key=lambda each: (each.span.file.name, each.span.start)):
        path = [structure]
        branches = [_contained(structure, structures)]
        while path:
            inner = next(branches[-1], None)
            if inner is None:
                done.add(path.pop().type.name)
                branches.pop()
            elif inner in path:
                circle = [*path[path.index(inner) :], inner]
                bag.add(messages.contains_itself, inner.span, tuple(each.type.name for each in circle))
                done.update(each.type.name for each in path)
            elif inner.type.name not in done:
                path.append(inner)
                branches.append(_contained(inner, structures))


def _contained(structure: plan.Structure, structures: plan.Structures) -> Iterator[plan.Structure]:
    """Yield the structures that every value of a structure contains."""
    for field in structure.fields.values():
        pending = [field.default] if field.default is not None else []
        while pending:
            current = pending.pop()
            if isinstance(current, plan.Construct):
                yield structures.of(current.type)
            pending += plan.parts(current)
        if field.default is None and isinstance(field.type, plan.StructType):
            inner = structures.find(field.type)
            if inner is not None:
                yield inner
