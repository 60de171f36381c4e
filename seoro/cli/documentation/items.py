"""Data of documented libraries."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from seoro.lang.frozen import Value


class Parameter(Value):
    """A parameter of an action, modifier, method or event, or a field of a struct or actor.

    Args:
        name: Its name.
        type: Its type in the syntax of the language.
        unit: SI unit of its values; empty without one.
        default: Its default as written; empty without one.
        meaning: Comment above its declaration.
        of: Type that it is inherited from; empty for an own one.
    """

    name: str
    type: str
    unit: str = ""
    default: str = ""
    meaning: str = ""
    of: str = ""

    @property
    def text(self) -> str:
        """The parameter as in its declaration."""
        return f"{self.name}: {self.type}{f' = {self.default}' if self.default else ''}"


class Item(Value):
    """A declaration of a library.

    Args:
        kind: `action`, `modifier`, `scenario`, `struct`, `actor`, `enum`, `type`, `method`, `event` or `global`.
        name: Its name; `robot.drive` for a member of `robot`.
        library: Library that declares it, such as `osc.nav2`, or the path of its file.
        meaning: Comment above the declaration, else the first paragraph of its implementation's docstring.
        parameters: Parameters or fields, inherited ones first.
        inherits: Base of a struct, actor, action or scenario; empty without one.
        result: Type that a method returns, or type of a global parameter; empty without one.
        values: Members of an enumeration with their numbers, or units of a physical type with their SI value.
        members: Methods and events of a struct or actor.
        is_implemented: Whether an action or modifier can be invoked.
    """

    kind: str
    name: str
    library: str
    meaning: str = ""
    parameters: tuple[Parameter, ...] = ()
    inherits: str = ""
    result: str = ""
    values: tuple[str, ...] = ()
    members: tuple[Item, ...] = ()
    is_implemented: bool = True

    @property
    def signature(self) -> str:
        """Its name with parameters, on one line."""
        arrow = f" -> {self.result}" if self.result and self.kind == "method" else ""
        of = f": {self.result}" if self.kind == "global" else ""
        has_list = self.kind in _CALLED or self.parameters
        inner = f"({', '.join(each.text for each in self.parameters)})" if has_list else ""
        return f"{self.name}{inner}{of}{arrow}"


_CALLED = ("action", "modifier", "method", "scenario")


class Library(Value):
    """A library.

    Args:
        name: Name to import, or the path of a file.
        meaning: Comment at the start of its file.
        items: Its declarations, in their order.
    """

    name: str
    meaning: str
    items: tuple[Item, ...] = ()


def all_items(libraries: tuple[Library, ...]) -> Iterator[Item]:
    """Yield all declarations with their members."""
    for library in libraries:
        for item in library.items:
            yield item
            yield from item.members


def plain(item: Item | Library) -> dict[str, Any]:
    """Return a library or a declaration as JSON data, without empty fields."""
    found: dict[str, Any] = {}
    for name in type(item).__match_args__:
        value = getattr(item, name)
        if name == "is_implemented":
            found |= {} if value else {name: False}
        elif value not in ("", ()):
            found[name] = [_plain(each) for each in value] if isinstance(value, tuple) else value
    return found


def _plain(value: Item | Parameter | str) -> Any:
    if isinstance(value, Item):
        return plain(value)
    if isinstance(value, Parameter):
        fields = {name: getattr(value, name) for name in type(value).__match_args__}
        return {name: text for name, text in fields.items() if text}
    return value
