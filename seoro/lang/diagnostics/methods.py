"""Messages of methods and of operators that look like them (E0340 to E0347)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import near_or_all
from seoro.lang.source import Span


def missing_only(span: Span, name: str, first: Span) -> Diagnostic:
    """A method that overrides another without `only` (7.3.7.2)."""
    text = f"`{name}` overrides another method without `only`"
    hint = "write `is only ...` to override it"
    return error("E0340", span, text, hint, other=first, remark="the other method is here")


def method_mismatch(span: Span, name: str, difference: str, first: Span) -> Diagnostic:
    """A method whose signature differs from that of the method it overrides (7.3.7.2)."""
    text = f"`{name}` differs from the method that it overrides in {difference}"
    return error("E0341", span, text, other=first, remark="the overridden method is here")


def unknown_method(span: Span, owner: str, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """A call of an unknown method."""
    return error(
        "E0342", span, f"{owner} has no method `{name}`", near_or_all(name, candidates, "its methods are")
    )


def no_result(span: Span, name: str) -> Diagnostic:
    """A method without a result in an expression (7.4.2.1)."""
    hint = "invoke it by `call`, or declare a result: `def ... -> <type> is ...`"
    return error("E0343", span, f"method `{name}` has no result", hint)


def invalid_operands(span: Span, name: str, expected: str) -> Diagnostic:
    """Invalid arguments of an operator like `size()`."""
    return error("E0344", span, f"`{name}` takes {expected}")


def undefined_it(span: Span) -> Diagnostic:
    """`it` in a place without an instance or member."""
    hint = "`it` is the instance of a type in its members, and the member of a list in `filter(...)` and the like"
    return error("E0345", span, "`it` is not defined here", hint)


def impossible_cast(span: Span, found: str, target: str) -> Diagnostic:
    """`as` between types without a common value (7.4.2.6)."""
    return error("E0346", span, f"{found} can never be converted to {target}")


def invalid_function_path(span: Span, path: str) -> Diagnostic:
    """An external method whose name is not a dotted path to a function."""
    hint = "write `external package.module.function()`"
    return error("E0347", span, f"expected the path of a Python function, found `{path}`", hint)
