"""Messages of types and expressions (E03)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error, warning
from seoro.lang.diagnostics import a
from seoro.lang.frozen import Frozen
from seoro.lang.habits import mismatch_help
from seoro.lang.source import Span

_VERBS = {
    "+": "added",
    "-": "subtracted",
    "*": "multiplied",
    "/": "divided",
    "%": "divided",
}


class Mismatch(Frozen):
    """A value of the wrong type."""

    span: Span
    expected: str
    found: str
    context: str = ""
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        where = f" for {self.context}" if self.context else ""
        text = f"expected {self.expected}{where}, found {self.found}"
        needed, found = self.expected.strip("`"), self.found.strip("`")
        hint = self.help or mismatch_help(self.context, needed, found, self.span.text)
        return error("E0301", self.span, text, label=f"this is {a(self.found)}", help=hint)


class UnlikeOperands(Frozen):
    """Operands that an arithmetic operator cannot join."""

    span: Span
    left: Span
    right: Span
    operator: str
    left_type: str
    right_type: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"{self.left_type} and {self.right_type} cannot be {_VERBS[self.operator]}"
        other = Label(self.right, f"this is {a(self.right_type)}")
        return error("E0312", self.left, text, other, label=f"this is {a(self.left_type)}", help=self.help)


class UnlikeComparison(Frozen):
    """Operands that cannot be compared."""

    left: Span
    right: Span
    operator: str
    left_type: str
    right_type: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"{self.left_type} and {self.right_type} cannot be compared by `{self.operator}`"
        other = Label(self.right, f"this is {a(self.right_type)}")
        return error("E0313", self.left, text, other, label=f"this is {a(self.left_type)}")


class NoOrder(Frozen):
    """An order asked of values that have none."""

    span: Span
    operator: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "only numbers have an order; others compare by `==`, `!=` and `in`"
        return error("E0314", self.span, f"`{self.operator}` does not apply to {self.found}", help=hint)


class NotBool(Frozen):
    """A value where true or false is needed."""

    span: Span
    operator: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0315", self.span, f"`{self.operator}` needs bool, found {self.found}")


class NotNumber(Frozen):
    """A value where a number is needed."""

    span: Span
    operator: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0316", self.span, f"`{self.operator}` needs a number, found {self.found}")


class NoContainer(Frozen):
    """`in` with something on its right that holds nothing."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0317", self.span, f"`in` needs a list or a range, found {self.found}")


class NoCommonType(Frozen):
    """Values that should be of one type and are not."""

    span: Span
    other: Span
    what: str
    left: str
    right: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        first = Label(self.other, f"this is {a(self.left)}")
        text = f"{self.what} have no common type"
        return error("E0318", self.span, text, first, label=f"this is {a(self.right)}")


class NoFields(Frozen):
    """A member access on a value without members."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0319", self.span, f"{self.found} has no fields")


class NoElements(Frozen):
    """An index on a value that is no list."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0320", self.span, f"only lists have elements, this is {self.found}")


class WrongIndex(Frozen):
    """An index that is no integer."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0321", self.span, f"the index of a list is an integer, found {self.found}")


class NotNumericRange(Frozen):
    """A range of something that is no number (7.3.5.2.2)."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0322", self.span, f"a range is of numbers, not of {self.found}")


class ListOfList(Frozen):
    """A list of lists (7.3.5.2.1)."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0323", self.span, "a list cannot hold lists", help="put the inner list into a struct")


class WrongUnitDimension(Frozen):
    """A unit with other exponents than its type (7.3.4)."""

    span: Span
    name: str
    quantity: str
    needed: str
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` is in {self.found}, but `{self.quantity}` is in {self.needed}"
        return error("E0324", self.span, text)


class NotAValue(Frozen):
    """A name that is no value by itself."""

    span: Span
    name: str
    kind: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0325", self.span, f"`{self.name}` is {self.kind}, not a value", help=self.help)


class LabelAsValue(Frozen):
    """A label where a value is needed, or where it does not stand for what is invoked under it (7.6.2.2).

    Args:
        is_invocation: Whether something is invoked under it.
        is_early: Whether nothing runs yet when the expression is evaluated.
    """

    span: Span
    name: str
    is_invocation: bool
    is_early: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        if not self.is_invocation:
            hint = "only the label of an invocation has fields: those of what is invoked"
        elif self.is_early:
            hint = "nothing runs yet when this is evaluated: use its fields below `do`, in `on`, or in `sample`"
        else:
            hint = f"write `{self.name}.<field>` for a field of what is invoked"
        return error("E0348", self.span, f"`{self.name}` is a label, not a value", help=hint)


class NotCallable(Frozen):
    """Something applied to arguments that takes none."""

    span: Span
    name: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0326", self.span, f"`{self.name}` cannot be applied to arguments", help=self.help)


class NegativeUint(Frozen):
    """A negative number for `uint`."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0327", self.span, "`uint` holds no negative numbers", help="`int` does")


class IntTooLarge(Frozen):
    """A number for `int` that only `uint` holds."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0328", self.span, "this number is too large for `int`", help="`uint` holds it")


class WrongCondition(Frozen):
    """A condition of inheritance whose value is not one of its field (7.3.8.2)."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "a condition compares a `bool` or an enumeration with one of its values"
        return error("E0329", self.span, "this value cannot decide about the field", help=hint)


class FixedByCondition(Frozen):
    """A value for a field to which the condition of a conditional type gives another (7.3.8.2)."""

    span: Span
    owner: str
    name: str
    value: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` of `{self.owner}` is always {self.value}"
        return error("E0330", self.span, text, help="leave it out, or use the type that it inherits")


class BareNumber(Frozen):
    """A number without a unit for a physical parameter, which the standard does not have."""

    span: Span
    unit: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"it is read in {self.unit}; the standard asks for a unit"
        return warning("E0390", self.span, "a number without a unit", help=hint)


class StructConstructor(Frozen):
    """A struct applied to arguments, which the standard does not have."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "it constructs a value; other implementations may not know it"
        return warning("E0391", self.span, f"`{self.name}(...)` is an extension to the standard", help=hint)


class LibraryImport(Frozen):
    """An import of a library that is not the standard's."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` is not a module of the standard, which reserves `osc`"
        return warning("E0392", self.span, text, help="other implementations may not have it")


class AnyArgument(Frozen):
    """An argument of another type than declared, for a parameter that takes any."""

    span: Span
    parameter: str
    declared: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.parameter}` is declared as {self.declared}, and takes any type here"
        return warning("E0393", self.span, text)


class OrderOfRange(Frozen):
    """An order of a range and a number, which holds if it holds for all of the range: an extension."""

    span: Span
    operator: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.operator}` of a range and a number is an extension to the standard"
        hint = "compare a bound: `.lower()` or `.upper()`"
        return warning("E0394", self.span, text, help=hint)


class ReservedNamespace(Frozen):
    """A namespace with a name that the standard keeps for itself."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"the standard reserves `{self.name}`: names of namespaces that begin with `std` are its own"
        return warning("E0395", self.span, text, help="take a name such as `com_example_robots`")
