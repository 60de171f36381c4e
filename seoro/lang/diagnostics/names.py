"""Messages of declarations and names (E0210 to E0299)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error
from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.habits import METHODS, NAMES, TYPES, UNITS
from seoro.lang.provided import TYPES as DATA
from seoro.lang.provided import import_hint
from seoro.lang.source import Span


class Duplicate(Frozen):
    """A name that is declared twice."""

    span: Span
    what: str
    name: str
    first: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "first declared here")
        return error(
            "E0210",
            self.span,
            f"{self.what} `{self.name}` is declared twice",
            before,
            label="again here",
            help="rename or remove one of them",
        )


class UnknownType(Frozen):
    """A type that is not declared."""

    span: Span
    name: str
    candidates: tuple[str, ...]
    what: str = "type"
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        habits = METHODS if self.what == "method or struct" else TYPES
        hint = self.help or habits.get(self.name, "") or import_hint(self.name, DATA)
        return error(
            "E0211", self.span, f"unknown {self.what} `{self.name}`", help=hint or near(self.name, self.candidates)
        )


class WrongKind(Frozen):
    """A name of one kind where another kind is needed."""

    span: Span
    name: str
    kind: str
    needed: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0212", self.span, f"`{self.name}` is {self.kind}, not {self.needed}")


class UnknownUnit(Frozen):
    """A unit that is not declared."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        if UNITS.get(self.name) in self.candidates:
            hint = (
                f"a unit is one name: `{UNITS[self.name]}`" if "/" in self.name else f"write `{UNITS[self.name]}`"
            )
        elif self.name.startswith("_") and self.name.replace("_", "").isdigit():
            hint = "numbers have no separators"
        if not self.candidates:
            hint = "the units of the standard come with `import osc.types`"
        return error("E0213", self.span, f"unknown unit `{self.name}`", help=hint)


class UnknownBaseUnit(Frozen):
    """An SI base unit that does not exist."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0214", self.span, f"`{self.name}` is no SI base unit", help=f"these are {listing(self.candidates)}"
        )


class UnknownField(Frozen):
    """A member that a type does not have."""

    span: Span
    owner: str
    name: str
    candidates: tuple[str, ...]
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates) or self.help
        if not hint and self.candidates:
            hint = f"it has {listing(self.candidates)}"
        return error("E0215", self.span, f"{self.owner} has no field `{self.name}`", help=hint)


class UnknownName(Frozen):
    """A name in an expression that means nothing."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = NAMES.get(self.name) or near(self.name, self.candidates)
        return error("E0216", self.span, f"unknown name `{self.name}`", help=hint)


class UnknownMember(Frozen):
    """A member that an enumeration does not have."""

    span: Span
    enum: str
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        if self.name in self.candidates:
            hint = f"a member of an enumeration is written `{self.enum}!{self.name}`"
            return error("E0217", self.span, f"unknown name `{self.span.text}`", help=hint)
        hint = near(self.name, self.candidates) or f"its members are {listing(self.candidates)}"
        return error("E0217", self.span, f"`{self.enum}` has no member `{self.name}`", help=hint)


class AmbiguousMember(Frozen):
    """A member's name that several enumerations have, where nothing decides between them."""

    span: Span
    name: str
    enums: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"write {listing((f'{enum}!{self.name}' for enum in self.enums), 'or')}"
        what = f"`{self.name}` is a member of {listing(self.enums)}, and nothing here decides which one is meant"
        return error("E0218", self.span, what, help=hint)


class CyclicReference(Frozen):
    """Declarations that refer to each other in a circle."""

    span: Span
    what: str
    path: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0219", self.span, f"{self.what} form a cycle: {' -> '.join(self.path)}")


class TooManyBases(Frozen):
    """A line of bases that is longer than what is taken."""

    span: Span
    limit: int

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "let it inherit from a type further up"
        return error(
            "E0133", self.span, f"inherits from more than {self.limit} types, one from another", help=hint
        )


class WrongBase(Frozen):
    """A scenario or action inherits from one of an unrelated actor (7.3.8.1)."""

    span: Span
    name: str
    base: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "both belong to no actor, or the base belongs to the same actor or one that it inherits from"
        return error("E0220", self.span, f"`{self.name}` cannot inherit from `{self.base}`", help=hint)


class AmbiguousName(Frozen):
    """A name that several namespaces in use export (7.7.4.2)."""

    span: Span
    name: str
    namespaces: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"write {listing((f'{namespace}::{self.name}' for namespace in self.namespaces), 'or')}"
        return error("E0221", self.span, f"several namespaces in use export `{self.name}`", help=hint)


class UnknownNamespace(Frozen):
    """A namespace in which nothing is defined."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        return error("E0222", self.span, f"nothing is defined in a namespace `{self.name}`", help=hint)


class UnknownExport(Frozen):
    """An exported name that nothing has."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0223", self.span, f"nothing is called `{self.name}`, so it cannot be exported")


class UnconditionalBase(Frozen):
    """A type that inherits a conditional one without a condition (7.3.8.2.3)."""

    span: Span
    name: str
    base: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"give it a condition as well: `inherits {self.base}(<field> == <value>)`"
        text = f"`{self.base}` depends on a condition, so `{self.name}` cannot inherit it without one"
        return error("E0224", self.span, text, help=hint)


class VariableDeterminant(Frozen):
    """A conditional subtype that depends on a variable (7.3.8.2)."""

    span: Span
    name: str
    declared: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error(
            "E0298",
            self.span,
            f"the type of a value cannot depend on the variable `{self.name}`, which may change",
            Label(self.declared, "declared as a variable here"),
            help="declare it without `var`, as a parameter",
        )
