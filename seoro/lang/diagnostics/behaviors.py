"""Messages of behaviors, instantiation, constraints and times (E0401 to E0444, E0454, E0480 to E0482).

Unsatisfied constraints are reported by runs, from E0442.
"""

from __future__ import annotations

from collections.abc import Sequence

from seoro.lang.builtin_libraries import BEHAVIORS, import_hint
from seoro.lang.diagnostic import Diagnostic, error, warning
from seoro.lang.diagnostics import listing, near, near_or_all
from seoro.lang.habits import BEHAVIORS as HABITS
from seoro.lang.source import Span

FILE_NOT_FOUND = "E0414"


def unknown_behavior(
    span: Span, name: str, actor: str | None, candidates: tuple[str, ...], hint: str = ""
) -> Diagnostic:
    """Invocation of an unknown scenario or action."""
    kind = "scenario or action"
    text = f"actor `{actor}` has no {kind} `{name}`" if actor else f"unknown {kind} `{name}`"
    hint = hint or import_hint(name, BEHAVIORS, actor) or HABITS.get(name, "").format(name)
    hint = hint or (near_or_all(name, candidates, "available:") if actor else near(name, candidates))
    return error("E0401", span, text, hint)


def not_an_actor(span: Span, found: str) -> Diagnostic:
    """Invocation of a behavior of something other than an actor."""
    return error("E0402", span, f"expected an actor before the behavior, found {found}")


def method_invoked(span: Span, name: str) -> Diagnostic:
    """Invocation of a method."""
    hint = "call a method with a result in an expression, any other method with `call`"
    return error("E0427", span, f"`{name}` is a method; expected a scenario or an action", hint)


def global_without_value(span: Span, name: str) -> Diagnostic:
    """A global parameter without a value."""
    return error("E0428", span, f"global parameter `{name}` has no value", "give it a default")


def unknown_argument(span: Span, owner: str, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """A named argument without a parameter of that name."""
    hint = near_or_all(name, candidates, "its parameters are") or "it has no parameters"
    return error("E0403", span, f"`{owner}` has no parameter `{name}`", hint)


def too_many_arguments(span: Span, owner: str, limit: int) -> Diagnostic:
    """More positional arguments than parameters."""
    expected = {0: "no arguments", 1: "one argument"}.get(limit, f"{limit} arguments")
    return error("E0404", span, f"too many arguments: `{owner}` takes {expected}")


def duplicate_argument(span: Span, name: str, first: Span) -> Diagnostic:
    """A second value for a parameter."""
    return error("E0405", span, f"duplicate argument `{name}`", other=first, remark="first given here")


def missing_argument(span: Span, owner: str, name: str) -> Diagnostic:
    """A parameter without an argument."""
    return error("E0406", span, f"missing argument `{name}` of `{owner}`", f"add `{name}: ...`")


def missing_value(span: Span, name: str) -> Diagnostic:
    """A parameter without a value."""
    return error("E0407", span, f"'{name}' has no value: give it a default or an override")


def duplicate_do(span: Span, first: Span, inherited: bool) -> Diagnostic:
    """A second `do` (7.3.5.1.3)."""
    remark = "inherited from here" if inherited else "the first `do`"
    hint = "join both in one `do parallel:`"
    return error("E0413", span, "duplicate `do`: a scenario has only one", hint, other=first, remark=remark)


def missing_scenario(span: Span) -> Diagnostic:
    """A file without a scenario to run."""
    return error("E0420", span, "missing scenario to run", "declare a scenario in this file, or run another file")


def ambiguous_entry(span: Span, candidates: tuple[str, ...]) -> Diagnostic:
    """Several scenarios, none of which was chosen."""
    hint = f"choose {listing(candidates, 'or')} with `--scenario`, or name one of them `main`"
    return error("E0421", span, "this file declares several scenarios; choose one to run", hint)


def unknown_entry(span: Span, name: str, candidates: tuple[str, ...]) -> Diagnostic:
    """The chosen scenario is missing in the file."""
    hint = near_or_all(name, candidates, "this file declares")
    return error("E0422", span, f"unknown scenario `{name}`", hint)


def actor_entry(span: Span, name: str) -> Diagnostic:
    """The chosen scenario belongs to an actor, which a run does not have."""
    hint = f"write a scenario with a field for the actor, and invoke `{name}` on it"
    return error("E0423", span, f"`{name}` belongs to an actor and cannot run by itself", hint)


def invalid_override(span: Span, path: str, reason: str, hint: str = "") -> Diagnostic:
    """An override that does not fit the scenario."""
    return error("E0424", span, f"cannot override `{path}`: {reason}", hint)


def contains_itself(span: Span, types: tuple[str, ...]) -> Diagnostic:
    """A type whose values contain values of the same type, without end."""
    return error("E0426", span, f"a value would contain itself without end: {' -> '.join(types)}")


def missing_file(span: Span, name: str, is_uri: bool) -> Diagnostic:
    """A literal with the name of a file that is missing on this machine."""
    hint = "paths are relative to the folder of the scenario file"
    if is_uri:
        hint = (
            "write `name://path` for a model on the model path, or `file:///path` for a file; ignore this "
            "warning if the file is on the machine of the simulator"
        )
    return warning(FILE_NOT_FOUND, span, f"file not found: `{name}`", hint)


def unsuitable_text(span: Span, message: str, hint: str) -> Diagnostic:
    """A literal that the action will refuse, such as an unknown type of ROS."""
    return warning("E0415", span, message, hint)


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


def negative_time(span: Span, what: str, is_positive: bool) -> Diagnostic:
    """An invalid time literal.

    Args:
        span: The literal.
        what: Purpose of the time.
        is_positive: Whether zero is invalid, too.
    """
    if is_positive:
        return error("E0454", span, f"the {what} must be longer than zero", "use more than `0s`")
    return error("E0454", span, f"the {what} must not be negative", "use `0s` or more")


def parallel_only(span: Span, name: str, operator: str) -> Diagnostic:
    """An argument of `parallel` for another composition (7.3.13.2)."""
    return error("E0480", span, f"`{name}` is a parameter of `parallel`, not of `{operator}`")


def unknown_overlap(span: Span, candidates: tuple[str, ...]) -> Diagnostic:
    """An unknown kind of overlap (7.3.13.2)."""
    hint = near_or_all(span.text, candidates, "the kinds are")
    return error("E0481", span, f"unknown kind of overlap `{span.text}`", hint)


def contradictory_offset(span: Span, name: str, overlap: str, low: float, high: float) -> Diagnostic:
    """An offset that the kind of overlap excludes (7.3.13.2)."""
    expected = "zero" if low == high else "zero or more" if low == 0 else "zero or less"
    text = f"with `overlap: {overlap}`, `{name}` has to be {expected}"
    return error("E0482", span, text, "`overlap: any` allows any offset")


def constrained_variable(span: Span, path: str, declared: Span) -> Diagnostic:
    """A constraint that contains only variables."""
    text = f"`{path}` is a variable, and variables cannot be constrained"
    hint = "constrain a parameter, or wait for the condition: `wait <condition>`"
    return error("E0440", span, text, hint, other=declared, remark="the variable is declared here")


def not_a_parameter(span: Span, path: str, declared: Span | None) -> Diagnostic:
    """`remove_default` of something other than a parameter."""
    expected, found = ("a parameter", "the variable ") if declared else ("the path of a parameter", "")
    text = f"expected {expected}, found {found}`{path}`"
    hint = "`remove_default` removes the default of a parameter"
    return error("E0441", span, text, hint, other=declared, remark="declared here")


def not_a_variable(span: Span, path: str, parameter: Span | None) -> Diagnostic:
    """Something other than the path of a variable."""
    if parameter is None:
        return error("E0444", span, "expected the path of a variable", label="this is a value")
    text = f"`{path}` is a parameter, which does not change"
    hint = f"declare it as a variable: `var {parameter.text}: ...`"
    return error("E0444", span, text, hint, other=parameter, remark="declared here")
