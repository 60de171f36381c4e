"""Messages of behaviors, events and instantiation (E04)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, Label, error, warning
from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.habits import BEHAVIORS as HABITS
from seoro.lang.provided import BEHAVIORS, import_hint
from seoro.lang.source import Span

FILE_NOT_FOUND = "E0414"


class UnknownBehavior(Frozen):
    """An invocation of what is no scenario or action."""

    span: Span
    name: str
    actor: str | None
    candidates: tuple[str, ...]
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        what = f"actor `{self.actor}` has no scenario or action" if self.actor else "unknown scenario or action"
        hint = import_hint(self.name, BEHAVIORS, self.actor) or HABITS.get(self.name, "").format(self.name)
        hint = self.help or hint or near(self.name, self.candidates)
        if not hint and self.actor and self.candidates:
            hint = f"it has {listing(self.candidates)}"
        return error("E0401", self.span, f"{what} `{self.name}`", help=hint)


class NotAnActor(Frozen):
    """A behavior invoked on something that is no actor."""

    span: Span
    found: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0402", self.span, f"behaviors belong to actors, this is {self.found}")


class MethodInvoked(Frozen):
    """A method where a behavior is invoked."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "methods with a result are called in expressions, others by `call`"
        return error("E0427", self.span, f"`{self.name}` is a method, not a scenario or an action", help=hint)


class GlobalWithoutValue(Frozen):
    """A global parameter that nothing gives a value."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0428", self.span, f"global parameter `{self.name}` has no value: give it a default")


class UnknownArgument(Frozen):
    """A named argument that the parameters do not have."""

    span: Span
    owner: str
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        if not hint:
            hint = f"its parameters are {listing(self.candidates)}" if self.candidates else "it has no parameters"
        return error("E0403", self.span, f"`{self.owner}` has no parameter `{self.name}`", help=hint)


class TooManyArguments(Frozen):
    """More positional arguments than parameters."""

    span: Span
    owner: str
    limit: int

    def diagnostic(self) -> Diagnostic:
        """The message."""
        takes = {0: "no arguments", 1: "one argument"}.get(self.limit, f"{self.limit} arguments")
        return error("E0404", self.span, f"too many arguments: `{self.owner}` takes {takes}")


class ArgumentTwice(Frozen):
    """A parameter that is given two values."""

    span: Span
    name: str
    first: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "first given here")
        return error("E0405", self.span, f"`{self.name}` is given twice", before)


class MissingArgument(Frozen):
    """A parameter that gets no value."""

    span: Span
    owner: str
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.owner}` needs a value for `{self.name}`"
        return error("E0406", self.span, text, help=f"add `{self.name}: ...`")


class NoValue(Frozen):
    """A parameter that nothing gives a value."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0407", self.span, f"'{self.name}' has no value: give it a default or an override")


class SecondDo(Frozen):
    """A second `do` (7.3.5.1.3)."""

    span: Span
    first: Span
    inherited: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        before = Label(self.first, "inherited from here" if self.inherited else "the first one is here")
        return error(
            "E0413", self.span, "a scenario has only one `do`", before, help="join them by `parallel:` in one"
        )


class NoScenario(Frozen):
    """A file that has no scenario to run."""

    span: Span

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0420", self.span, "this file declares no scenario", help="a scenario is needed to run it")


class AmbiguousEntry(Frozen):
    """Several scenarios, and nothing that says which one to run."""

    span: Span
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = f"choose one of {listing(self.candidates, 'or')} by `--scenario`, or call one `main`"
        return error("E0421", self.span, "which scenario is to run?", help=hint)


class UnknownEntry(Frozen):
    """The scenario that was asked for is not in the file."""

    span: Span
    name: str
    candidates: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.candidates)
        if not hint and self.candidates:
            hint = f"it declares {listing(self.candidates)}"
        return error("E0422", self.span, f"this file declares no scenario `{self.name}`", help=hint)


class ActorEntry(Frozen):
    """The entry scenario belongs to an actor, which nobody gives it."""

    span: Span
    name: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "write a scenario that has an actor of its own and invokes it"
        return error("E0423", self.span, f"`{self.name}` belongs to an actor and cannot run by itself", help=hint)


class WrongOverride(Frozen):
    """An override that does not fit the scenario."""

    span: Span
    path: str
    reason: str
    help: str = ""

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0424", self.span, f"cannot override `{self.path}`: {self.reason}", help=self.help)


class ContainsItself(Frozen):
    """A value that would hold one of its own type, and so on."""

    span: Span
    path: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"a value would contain itself without end: {' -> '.join(self.path)}"
        return error("E0426", self.span, text)


class MissingFile(Frozen):
    """A literal that names a file which does not exist on this machine."""

    span: Span
    name: str
    is_uri: bool

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"file not found: `{self.name}`"
        hint = "paths are relative to the folder of the scenario file"
        if self.is_uri:
            hint = (
                "write `name://path` for a model on the model path, or `file:///path` for a file; ignore this "
                "warning if the file is on the machine of the simulator"
            )
        return warning(FILE_NOT_FOUND, self.span, text, help=hint)
