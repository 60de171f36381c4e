"""Messages of behaviors and instantiation (E0401 to E0428)."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.lang.diagnostic import Severity
from seoro.lang.diagnostics.template import TemplateMessage
from seoro.lang.habits import BEHAVIORS as HABITS
from seoro.lang.import_hints import BEHAVIORS, import_hint
from seoro.lang.source import Span

FILE_NOT_FOUND = "E0414"


class UnknownBehavior(TemplateMessage):
    """Invocation of an unknown scenario or action."""

    CODE = "E0401"
    TEXT = ("actor `{actor}` has no scenario or action `{name}`", "unknown scenario or action `{name}`")
    HELP = ("{help}", "{_imported}", "{_habit}", "{near}", "{actor:if}available: {candidates:and}")

    name: str
    actor: str | None
    candidates: tuple[str, ...]
    help: str = ""

    @property
    def _imported(self) -> str:
        return import_hint(self.name, BEHAVIORS, self.actor)

    @property
    def _habit(self) -> str:
        return HABITS.get(self.name, "").format(self.name)


class NotAnActor(TemplateMessage):
    """Invocation of a behavior of something other than an actor."""

    CODE = "E0402"
    TEXT = "expected an actor before the behavior, found {found}"

    found: str


class MethodInvoked(TemplateMessage):
    """Invocation of a method."""

    CODE = "E0427"
    TEXT = "`{name}` is a method; expected a scenario or an action"
    HELP = "call a method with a result in an expression, any other method with `call`"

    name: str


class GlobalWithoutValue(TemplateMessage):
    """A global parameter without a value."""

    CODE = "E0428"
    TEXT = "global parameter `{name}` has no value"
    HELP = "give it a default"

    name: str


class UnknownArgument(TemplateMessage):
    """A named argument without a parameter of that name."""

    CODE = "E0403"
    TEXT = "`{owner}` has no parameter `{name}`"
    HELP = ("{near}", "its parameters are {candidates:and}", "it has no parameters")

    owner: str
    name: str
    candidates: tuple[str, ...]


class TooManyArguments(TemplateMessage):
    """More positional arguments than parameters."""

    CODE = "E0404"
    TEXT = "too many arguments: `{owner}` takes {_expected}"

    owner: str
    limit: int

    @property
    def _expected(self) -> str:
        return {0: "no arguments", 1: "one argument"}.get(self.limit, f"{self.limit} arguments")


class DuplicateArgument(TemplateMessage):
    """A second value for a parameter."""

    CODE = "E0405"
    TEXT = "duplicate argument `{name}`"
    OTHERS = (("first", "first given here"),)

    name: str
    first: Span


class MissingArgument(TemplateMessage):
    """A parameter without an argument."""

    CODE = "E0406"
    TEXT = "missing argument `{name}` of `{owner}`"
    HELP = "add `{name}: ...`"

    owner: str
    name: str


class MissingValue(TemplateMessage):
    """A parameter without a value."""

    CODE = "E0407"
    TEXT = "'{name}' has no value: give it a default or an override"

    name: str


class DuplicateDo(TemplateMessage):
    """A second `do` (7.3.5.1.3)."""

    CODE = "E0413"
    TEXT = "duplicate `do`: a scenario has only one"
    HELP = "join both in one `do parallel:`"
    OTHERS = (("first", ("{inherited:if}inherited from here", "the first `do`")),)

    first: Span
    inherited: bool


class MissingScenario(TemplateMessage):
    """A file without a scenario to run."""

    CODE = "E0420"
    TEXT = "missing scenario to run"
    HELP = "declare a scenario in this file, or run another file"


class AmbiguousEntry(TemplateMessage):
    """Several scenarios, none of which was chosen."""

    CODE = "E0421"
    TEXT = "this file declares several scenarios; choose one to run"
    HELP = "choose {candidates:or} with `--scenario`, or name one of them `main`"

    candidates: tuple[str, ...]


class UnknownEntry(TemplateMessage):
    """The chosen scenario is missing in the file."""

    CODE = "E0422"
    TEXT = "unknown scenario `{name}`"
    HELP = ("{near}", "this file declares {candidates:and}")

    name: str
    candidates: tuple[str, ...]


class ActorEntry(TemplateMessage):
    """The chosen scenario belongs to an actor, which a run does not have."""

    CODE = "E0423"
    TEXT = "`{name}` belongs to an actor and cannot run by itself"
    HELP = "write a scenario with a field for the actor, and invoke `{name}` on it"

    name: str


class InvalidOverride(TemplateMessage):
    """An override that does not fit the scenario."""

    CODE = "E0424"
    TEXT = "cannot override `{path}`: {reason}"
    HELP = "{help}"

    path: str
    reason: str
    help: str = ""


class ContainsItself(TemplateMessage):
    """A type whose values contain values of the same type, without end."""

    CODE = "E0426"
    TEXT = "a value would contain itself without end: {_path}"

    types: tuple[str, ...]

    @property
    def _path(self) -> str:
        return " -> ".join(self.types)


class MissingFile(TemplateMessage):
    """A literal with the name of a file that is missing on this machine."""

    CODE = FILE_NOT_FOUND
    SEVERITY = Severity.WARNING
    TEXT = "file not found: `{name}`"
    HELP = (
        "{is_uri:if}write `name://path` for a model on the model path, or `file:///path` for a file; ignore this "
        "warning if the file is on the machine of the simulator",
        "paths are relative to the folder of the scenario file",
    )

    name: str
    is_uri: bool


def made_by_field(actor: str, parameters: Sequence[str]) -> str:
    """Help for a constructor call of an actor.

    Args:
        actor: Name of the actor.
        parameters: Names of the fields that get a value.
    """
    text = f"create an actor by a field: `<name>: {actor}`"
    if not parameters:
        return text
    return f"{text}, with a block `with:` that has `keep(it.{parameters[0]} == <value>)`"
