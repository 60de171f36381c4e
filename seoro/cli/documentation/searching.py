"""Search in documented libraries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from seoro.cli.documentation.items import Item, Library, all_items

CALLED = ("action", "modifier", "scenario")


def find_items(libraries: tuple[Library, ...], name: str) -> list[Item]:
    """Return the declarations with a name: their own, with the actor, or with the library before it.

    Args:
        libraries: The searched libraries.
        name: For example `nav_to_pose`, `robot.nav_to_pose`, `osc.nav2.nav_to_pose`, or a unit.
    """
    items = list(all_items(libraries))
    found = [item for item in items if name in _names(item)]
    return found or [item for item in items if item.kind == "type" and name in _units(item)]


def _names(item: Item) -> Iterator[str]:
    last = item.name.rpartition(".")[2]
    yield from (item.name, last, f"{item.library}.{item.name}", f"{item.library}.{last}")


def _units(item: Item) -> set[str]:
    return {each.partition(" ")[0] for each in item.values}


def known_names(libraries: tuple[Library, ...]) -> list[str]:
    """Return the names of all declarations, for suggestions and completion."""
    return sorted({item.name for item in all_items(libraries)})


def related_to(actor: Item, libraries: tuple[Library, ...]) -> Sequence[Item]:
    """Return the actions and modifiers of an actor and its bases; empty for other declarations."""
    if actor.kind != "actor":
        return ()
    items = list(all_items(libraries))
    bases = {item.name: item.inherits for item in items if item.kind == "actor"}
    lineage = [actor.name]
    while base := bases.get(lineage[-1]):
        lineage.append(base)
    return [item for item in items if item.kind in CALLED and item.name.rpartition(".")[0] in lineage]
