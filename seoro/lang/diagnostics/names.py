"""Messages of declarations and names (E0210 to E0298)."""

from __future__ import annotations

from seoro.lang.diagnostics import near
from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.habits import METHODS, NAMES, TYPES, UNITS
from seoro.lang.import_hints import TYPES as DATA
from seoro.lang.import_hints import import_hint
from seoro.lang.source import Span


class Duplicate(TemplateMessage):
    """A second declaration of a name."""

    CODE = "E0210"
    TEXT = "duplicate {what} `{name}`"
    LABEL = "again here"
    HELP = "rename or remove one of them"
    OTHERS = (("first", "first declared here"),)

    what: str
    name: str
    first: Span


class UnknownType(TemplateMessage):
    """An undeclared type."""

    CODE = "E0211"
    TEXT = "unknown {what} `{name}`"
    HELP = ("{help}", "{_habit}", "{_imported}", "{near}")

    name: str
    candidates: tuple[str, ...]
    what: str = "type"
    help: str = ""

    @property
    def _habit(self) -> str:
        return (METHODS if self.what == "method or struct" else TYPES).get(self.name, "")

    @property
    def _imported(self) -> str:
        return import_hint(self.name, DATA)


class WrongKind(TemplateMessage):
    """A name of one kind where another kind is needed."""

    CODE = "E0212"
    TEXT = "expected {expected}, but `{name}` is {kind}"

    name: str
    kind: str
    expected: str


class UnknownUnit(TemplateMessage):
    """An undeclared unit."""

    CODE = "E0213"
    TEXT = "unknown unit `{name}`"
    HELP = "{_hint}"

    name: str
    candidates: tuple[str, ...]

    @property
    def _hint(self) -> str:
        if not self.candidates:
            return "the units of the standard come with `import osc.types`"
        unit = UNITS.get(self.name)
        if unit in self.candidates:
            return f"a unit is one name: `{unit}`" if "/" in self.name else f"write `{unit}`"
        if self.name.startswith("_") and self.name.replace("_", "").isdigit():
            return "numbers have no separators"
        return near(self.name, self.candidates)


class UnknownBaseUnit(TemplateMessage):
    """An unknown SI base unit."""

    CODE = "E0214"
    TEXT = "unknown SI base unit `{name}`"
    HELP = "the base units are {candidates:and}"

    name: str
    candidates: tuple[str, ...]


class UnknownField(TemplateMessage):
    """An unknown member of a type."""

    CODE = "E0215"
    TEXT = "{owner} has no field `{name}`"
    HELP = ("{near}", "{help}", "its fields are {candidates:and}")

    owner: str
    name: str
    candidates: tuple[str, ...]
    help: str = ""


class UnknownName(TemplateMessage):
    """An unknown name in an expression."""

    CODE = "E0216"
    TEXT = "unknown name `{name}`"
    HELP = ("{_habit}", "{near}")

    name: str
    candidates: tuple[str, ...]

    @property
    def _habit(self) -> str:
        return NAMES.get(self.name, "")


class UnknownMember(TemplateMessage):
    """An unknown member of an enumeration, or a known one without the enumeration."""

    CODE = "E0217"
    TEXT = ("{_is_bare:if}unknown name `{span.text}`", "`{enum}` has no member `{name}`")
    HELP = (
        "{_is_bare:if}write a member of an enumeration as `{enum}!{name}`",
        "{near}",
        "its members are {candidates:and}",
    )

    enum: str
    name: str
    candidates: tuple[str, ...]

    @property
    def _is_bare(self) -> bool:
        return self.name in self.candidates


class AmbiguousMember(TemplateMessage):
    """A member of several enumerations, where the type is not known."""

    CODE = "E0218"
    TEXT = "`{name}` is ambiguous: it is a member of {enums:and}"
    HELP = "write {_qualified:or}"

    name: str
    enums: tuple[str, ...]

    @property
    def _qualified(self) -> tuple[str, ...]:
        return tuple(f"{enum}!{self.name}" for enum in self.enums)


class CyclicReference(TemplateMessage):
    """Declarations that refer to each other in a cycle."""

    CODE = "E0219"
    TEXT = "{what} form a cycle: {_path}"

    what: str
    names: tuple[str, ...]

    @property
    def _path(self) -> str:
        return " -> ".join(self.names)


class TooManyBases(TemplateMessage):
    """A chain of bases that exceeds the limit."""

    CODE = "E0133"
    TEXT = "inherits from a chain of more than {limit} types"
    HELP = "inherit from a type further up"

    limit: int


class InvalidBase(TemplateMessage):
    """A scenario or action that inherits from one of an unrelated actor (7.3.8.1)."""

    CODE = "E0220"
    TEXT = "`{name}` cannot inherit from `{base}`"
    HELP = "both belong to no actor, or the base belongs to the same actor or one that it inherits from"

    name: str
    base: str


class AmbiguousName(TemplateMessage):
    """A name that several namespaces in use export (7.7.4.2)."""

    CODE = "E0221"
    TEXT = "`{name}` is ambiguous: several namespaces in use export it"
    HELP = "write {_qualified:or}"

    name: str
    namespaces: tuple[str, ...]

    @property
    def _qualified(self) -> tuple[str, ...]:
        return tuple(f"{namespace}::{self.name}" for namespace in self.namespaces)


class UnknownNamespace(TemplateMessage):
    """A namespace without definitions."""

    CODE = "E0222"
    TEXT = "unknown namespace `{name}`"
    HELP = "{near}"

    name: str
    candidates: tuple[str, ...]


class UnknownExport(TemplateMessage):
    """An exported name without a declaration."""

    CODE = "E0223"
    TEXT = "cannot export unknown name `{name}`"

    name: str


class UnconditionalBase(TemplateMessage):
    """A type that inherits a conditional one without a condition (7.3.8.2.3)."""

    CODE = "E0224"
    TEXT = "`{base}` depends on a condition, so `{name}` cannot inherit it without one"
    HELP = "add a condition: `inherits {base}(<field> == <value>)`"

    name: str
    base: str


class VariableDeterminant(TemplateMessage):
    """A conditional subtype that depends on a variable (7.3.8.2)."""

    CODE = "E0298"
    TEXT = "the type of a value cannot depend on the variable `{name}`, which may change"
    HELP = "declare it without `var`, as a parameter"
    OTHERS = (("declared", "declared as a variable here"),)

    name: str
    declared: Span
