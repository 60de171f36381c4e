"""Messages of types and expressions (E0301 to E0330, E0348, E0390 to E0395)."""

from __future__ import annotations

from seoro.lang.diagnostic import Severity
from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.habits import mismatch_help
from seoro.lang.source import Span


class Mismatch(TemplateMessage):
    """A value of the wrong type."""

    CODE = "E0301"
    TEXT = ("expected {expected} for {context}, found {found}", "expected {expected}, found {found}")
    LABEL = "this is {found:a}"
    HELP = ("{help}", "{_habit}")

    expected: str
    found: str
    context: str = ""
    help: str = ""

    @property
    def _habit(self) -> str:
        expected, found = self.expected.strip("`"), self.found.strip("`")
        return mismatch_help(self.context, expected, found, self.span.text)


class IncompatibleOperands(TemplateMessage):
    """Operands that an arithmetic operator cannot combine."""

    CODE = "E0312"
    TEXT = "{left_type} and {right_type} cannot be {_verb}"
    LABEL = "this is {left_type:a}"
    HELP = "{help}"
    OTHERS = (("right", "this is {right_type:a}"),)

    right: Span
    operator: str
    left_type: str
    right_type: str
    help: str = ""

    @property
    def _verb(self) -> str:
        return {"+": "added", "-": "subtracted", "*": "multiplied"}.get(self.operator, "divided")


class IncomparableOperands(TemplateMessage):
    """Operands that cannot be compared."""

    CODE = "E0313"
    TEXT = "{left_type} and {right_type} cannot be compared by `{operator}`"
    LABEL = "this is {left_type:a}"
    OTHERS = (("right", "this is {right_type:a}"),)

    right: Span
    operator: str
    left_type: str
    right_type: str


class Unordered(TemplateMessage):
    """An order of values that have none."""

    CODE = "E0314"
    TEXT = "`{operator}` does not apply to {found}"
    HELP = "only numbers have an order; others compare by `==`, `!=` and `in`"

    operator: str
    found: str


class NotBool(TemplateMessage):
    """An operand other than a boolean."""

    CODE = "E0315"
    TEXT = "`{operator}` needs bool, found {found}"

    operator: str
    found: str


class NotNumber(TemplateMessage):
    """An operand other than a number."""

    CODE = "E0316"
    TEXT = "`{operator}` needs a number, found {found}"

    operator: str
    found: str


class NotAContainer(TemplateMessage):
    """A right operand of `in` other than a list or a range."""

    CODE = "E0317"
    TEXT = "`in` needs a list or a range, found {found}"

    found: str


class NoCommonType(TemplateMessage):
    """Values without a common type."""

    CODE = "E0318"
    TEXT = "{what} have no common type"
    LABEL = "this is {right:a}"
    OTHERS = (("other", "this is {left:a}"),)

    other: Span
    what: str
    left: str
    right: str


class NoFields(TemplateMessage):
    """A member access on a value without members."""

    CODE = "E0319"
    TEXT = "{found} has no fields"

    found: str


class NotAList(TemplateMessage):
    """An index on a value other than a list."""

    CODE = "E0320"
    TEXT = "only lists have elements, found {found}"

    found: str


class InvalidIndex(TemplateMessage):
    """An index other than an integer."""

    CODE = "E0321"
    TEXT = "the index of a list is an integer, found {found}"

    found: str


class NotNumericRange(TemplateMessage):
    """A range of something other than numbers (7.3.5.2.2)."""

    CODE = "E0322"
    TEXT = "a range consists of numbers, found {found}"

    found: str


class ListOfList(TemplateMessage):
    """A list of lists (7.3.5.2.1)."""

    CODE = "E0323"
    TEXT = "a list cannot contain lists"
    HELP = "put the inner list into a struct"


class WrongUnitDimension(TemplateMessage):
    """A unit with other exponents than its type (7.3.4)."""

    CODE = "E0324"
    TEXT = "`{name}` is in {found}, but `{quantity}` is in {expected}"

    name: str
    quantity: str
    expected: str
    found: str


class NotAValue(TemplateMessage):
    """A name in an expression that does not denote a value."""

    CODE = "E0325"
    TEXT = "`{name}` is {kind}, not a value"
    HELP = "{help}"

    name: str
    kind: str
    help: str = ""


class NotCallable(TemplateMessage):
    """Arguments for something that takes none."""

    CODE = "E0326"
    TEXT = "`{name}` takes no arguments"
    HELP = "{help}"

    name: str
    help: str = ""


class NegativeUint(TemplateMessage):
    """A negative number for `uint`."""

    CODE = "E0327"
    TEXT = "`uint` cannot hold negative numbers"
    HELP = "use `int`"


class IntTooLarge(TemplateMessage):
    """A number that fits into `uint`, but not into `int`."""

    CODE = "E0328"
    TEXT = "this number is too large for `int`"
    HELP = "use `uint`"


class InvalidCondition(TemplateMessage):
    """A condition of inheritance without a value of its field (7.3.8.2)."""

    CODE = "E0329"
    TEXT = "invalid condition: expected a value of the field"
    HELP = "a condition compares a `bool` or an enumeration with one of its values"


class FixedByCondition(TemplateMessage):
    """A value for a field that the condition of a conditional type fixes to another one (7.3.8.2)."""

    CODE = "E0330"
    TEXT = "`{name}` of `{owner}` is always {value}"
    HELP = "omit it, or use the type that `{owner}` inherits"

    owner: str
    name: str
    value: str


class LabelAsValue(TemplateMessage):
    """A label in an expression, where it is not a value or not one of an invocation (7.6.2.2).

    Args:
        is_invocation: Whether the label belongs to an invocation.
        is_early: Whether the expression is evaluated before the scenario runs.
    """

    CODE = "E0348"
    TEXT = "`{name}` is a label, not a value"
    HELP = "{_hint}"

    name: str
    is_invocation: bool
    is_early: bool

    @property
    def _hint(self) -> str:
        if not self.is_invocation:
            return "only the label of an invocation has fields: those of the invoked behavior"
        if self.is_early:
            return "nothing runs yet when this is evaluated: use its fields below `do`, in `on`, or in `sample`"
        return f"write `{self.name}.<field>` for a field of the invoked behavior"


class BareNumber(TemplateMessage):
    """A number without a unit for a physical parameter: an extension to the standard."""

    CODE = "E0390"
    SEVERITY = Severity.WARNING
    TEXT = "a number without a unit"
    HELP = "it is read in {unit}; the standard requires a unit"

    unit: str


class StructConstructor(TemplateMessage):
    """Construction of a struct from arguments: an extension to the standard."""

    CODE = "E0391"
    SEVERITY = Severity.WARNING
    TEXT = "`{name}(...)` is an extension to the standard"
    HELP = "it constructs a value; other implementations may not support it"

    name: str


class LibraryImport(TemplateMessage):
    """Import of a library that is not part of the standard."""

    CODE = "E0392"
    SEVERITY = Severity.WARNING
    TEXT = "`{name}` is not a module of the standard, which reserves `osc`"
    HELP = "other implementations may not have it"

    name: str


class AnyArgument(TemplateMessage):
    """An argument of another type than declared, for a parameter that accepts any."""

    CODE = "E0393"
    SEVERITY = Severity.WARNING
    TEXT = "`{parameter}` is declared as {declared}, and accepts any type here"

    parameter: str
    declared: str


class OrderOfRange(TemplateMessage):
    """An order of a range and a number, which holds if it holds for the whole range: an extension."""

    CODE = "E0394"
    SEVERITY = Severity.WARNING
    TEXT = "`{operator}` of a range and a number is an extension to the standard"
    HELP = "compare a bound: `.lower()` or `.upper()`"

    operator: str


class ReservedNamespace(TemplateMessage):
    """A namespace with a name that the standard reserves."""

    CODE = "E0395"
    SEVERITY = Severity.WARNING
    TEXT = "the standard reserves `{name}`, as all namespaces that begin with `std`"
    HELP = "use a name such as `com_example_robots`"

    name: str
