"""Messages of methods and of operators that look like them (E0340 to E0347)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.source import Span


class MissingOnly(TemplateMessage):
    """A method that overrides another without `only` (7.3.7.2)."""

    CODE = "E0340"
    TEXT = "`{name}` overrides another method without `only`"
    HELP = "write `is only ...` to override it"
    OTHERS = (("first", "the other method is here"),)

    name: str
    first: Span


class MethodMismatch(TemplateMessage):
    """A method whose signature differs from that of the method it overrides (7.3.7.2)."""

    CODE = "E0341"
    TEXT = "`{name}` differs from the method that it overrides in {difference}"
    OTHERS = (("first", "the overridden method is here"),)

    name: str
    difference: str
    first: Span


class UnknownMethod(TemplateMessage):
    """A call of an unknown method."""

    CODE = "E0342"
    TEXT = "{owner} has no method `{name}`"
    HELP = ("{near}", "its methods are {candidates:and}")

    owner: str
    name: str
    candidates: tuple[str, ...]


class NoResult(TemplateMessage):
    """A method without a result in an expression (7.4.2.1)."""

    CODE = "E0343"
    TEXT = "method `{name}` has no result"
    HELP = "invoke it by `call`, or declare a result: `def ... -> <type> is ...`"

    name: str


class InvalidOperands(TemplateMessage):
    """Invalid arguments of an operator like `size()`."""

    CODE = "E0344"
    TEXT = "`{name}` takes {expected}"

    name: str
    expected: str


class UndefinedIt(TemplateMessage):
    """`it` in a place without an instance or member."""

    CODE = "E0345"
    TEXT = "`it` is not defined here"
    HELP = "`it` is the instance of a type in its members, and the member of a list in `filter(...)` and the like"


class ImpossibleCast(TemplateMessage):
    """`as` between types without a common value (7.4.2.6)."""

    CODE = "E0346"
    TEXT = "{found} can never be converted to {target}"

    found: str
    target: str


class InvalidFunctionPath(TemplateMessage):
    """An external method whose name is not a dotted path to a function."""

    CODE = "E0347"
    TEXT = "expected the path of a Python function, found `{path}`"
    HELP = "write `external package.module.function()`"

    path: str
