"""External methods (7.3.7.4): passing the arguments of a method to its Python function.

The function first receives the run, if its first parameter is annotated with `MethodContext`. The positional
arguments in the parentheses follow. Then come, by name, the named arguments and the method's own parameters that
no argument replaces. A function that takes none of the method's parameters by name, such as `math.sin`, receives
them in order, after the positional arguments.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from seoro.deferred import dataclass
from seoro.errors import SeoroError
from seoro.lang import frozen
from seoro.lang.plan import External, Method, PrimitiveType, ValueType
from seoro.runtime.functions.fitting import Converter, Fitting, annotation_for
from seoro.runtime.functions.methods import MethodFailed
from seoro.runtime.functions.signatures import BY_NAME, SignatureMismatch, shown, signature_of, type_name
from seoro.runtime.values.environment import MethodContext
from seoro.runtime.values.values import Value


class BoundFunction(frozen.Value):
    """Python function of an external method.

    Args:
        name: Name of the method.
        function: The function.
        path: Name of the function in the scenario.
        takes_run: Whether its first parameter is the run.
        positional: Converters of the positional arguments in the parentheses.
        in_order: Names and converters of the parameters passed in order after those.
        by_name: Names and converters of the arguments passed by name.
        result: Type of the method's result, or None.
        fitting: Converts the result.
    """

    name: str
    function: Callable[..., Any]
    path: str
    takes_run: bool
    positional: Sequence[Converter]
    in_order: Mapping[str, Converter]
    by_name: Mapping[str, Converter]
    result: ValueType | None
    fitting: Fitting

    def __call__(
        self, run: MethodContext | None, positional: Sequence[Value], named: Mapping[str, Value]
    ) -> Value | None:
        """Call the function; return the result of the method, or None without one.

        Args:
            run: The run.
            positional: Values of the positional arguments in the parentheses.
            named: Values of the named arguments and of the method's parameters.

        Raises:
            MethodFailed: The function raised, or its result has another type.
        """
        returned = self._call(run, positional, named)
        if inspect.iscoroutine(returned):
            returned.close()  # otherwise Python warns that it was never awaited
        if self.result is None:
            return None
        value = self.fitting.value(returned, self.result)
        if value is None:
            found = "nothing" if returned is None else f"a value of {type(returned).__name__}"
            expected = getattr(self.result, "name", "a list or a range")
            raise MethodFailed(f"`{self.path}` returned {found}; expected `{expected}`")
        return value

    def _call(self, run: MethodContext | None, positional: Sequence[Value], named: Mapping[str, Value]) -> Any:
        if self.takes_run and run is None:
            raise MethodFailed(f"`{self.path}` needs a run, but is called without one")
        try:
            leading = [run] if self.takes_run else []
            first = [convert(value) for convert, value in zip(self.positional, positional, strict=True)]
            then = [convert(named[name]) for name, convert in self.in_order.items()]
            rest = {name: convert(named[name]) for name, convert in self.by_name.items()}
            return self.function(*leading, *first, *then, **rest)
        except SeoroError as error:  # its message is complete
            raise MethodFailed(f"`{self.name}` failed: {error}") from error
        except Exception as error:
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise MethodFailed(f"`{self.path}` failed: {reason}") from error


def bind_function(function: object, method: Method, external: External, fitting: Fitting) -> BoundFunction:
    """Bind an external method to a Python function.

    Raises:
        SignatureMismatch: It is not callable, is asynchronous, or its arguments or result differ.
    """
    if not callable(function):
        raise SignatureMismatch("it is not a function")
    called = function if inspect.isroutine(function) or isinstance(function, type) else type(function).__call__
    if inspect.iscoroutinefunction(function) or inspect.iscoroutinefunction(called):
        raise SignatureMismatch("it is asynchronous, but methods take no time; use an action instead")
    signature = _signature_of(function)
    taken = list(signature.parameters.values()) if signature is not None else []
    takes_run = bool(taken) and taken[0].annotation is MethodContext
    replaced = {name for name, _ in external.named}
    positional = [_Slot(argument.value.span.text, argument.type) for argument in external.positional]
    own = [_Slot(name, type_) for name, type_ in external.parameters if name not in replaced]
    named = [_Slot(name, argument.type) for name, argument in external.named]
    by_name, in_order = (own, []) if _takes_by_name(taken, own) else ([], own)
    by_name = [*named, *by_name]
    if signature is not None:
        _read_hints(signature, takes_run, [*positional, *in_order], by_name)
        _check_result(signature, method, fitting)
    return BoundFunction(
        method.name,
        function,
        external.path,
        takes_run,
        [slot.converter(fitting) for slot in positional],
        {slot.name: slot.converter(fitting) for slot in in_order},
        {slot.name: slot.converter(fitting) for slot in by_name},
        method.result,
        fitting,
    )


@dataclass(eq=False)
class _Slot:
    """Argument of a function.

    Args:
        name: Name of the argument or parameter; its text if it has no name.
        type: Its declared type.
        hint: Annotation of the parameter that receives it.
    """

    name: str
    type: ValueType
    hint: Any = object

    def converter(self, fitting: Fitting) -> Converter:
        """Return the converter to the annotated type."""
        found = fitting.converter(self.type, self.hint)
        if found is None:
            wanted = annotation_for(self.type)
            raise SignatureMismatch(f"it takes `{type_name(self.hint)}` where `{self.name}` gives `{wanted}`")
        return found


def _signature_of(function: Callable[..., Any]) -> inspect.Signature | None:
    """Return the signature of a function; None if it has none, as some functions written in C."""
    try:
        return signature_of(function)
    except SignatureMismatch:
        pass
    try:  # ignore annotations that cannot be evaluated
        found = inspect.signature(function)
    except (TypeError, ValueError):
        return None
    bare = [parameter.replace(annotation=inspect.Parameter.empty) for parameter in found.parameters.values()]
    return found.replace(parameters=bare, return_annotation=inspect.Signature.empty)


def _takes_by_name(taken: Sequence[inspect.Parameter], own: Sequence[_Slot]) -> bool:
    """Whether a function takes any of the method's parameters by name."""
    if any(parameter.kind is inspect.Parameter.VAR_KEYWORD for parameter in taken):
        return True
    names = {parameter.name for parameter in taken if parameter.kind in BY_NAME}
    return any(slot.name in names for slot in own)


def _read_hints(
    signature: inspect.Signature, takes_run: bool, in_order: Sequence[_Slot], by_name: Sequence[_Slot]
) -> None:
    """Set the annotation of each slot."""
    leading = [_Slot("run", PrimitiveType("string"))] if takes_run else []
    try:
        bound = signature.bind(*leading, *in_order, **{slot.name: slot for slot in by_name})
    except TypeError as error:
        given = ", ".join([*(slot.name for slot in in_order), *(f"{slot.name}: ..." for slot in by_name)])
        taken = shown(list(signature.parameters.values())[len(leading) :])
        raise SignatureMismatch(f"it takes ({taken}), and is given ({given})") from error
    for name, found in bound.arguments.items():
        parameter = signature.parameters[name]
        slots: Iterable[_Slot] = (found,)
        if parameter.kind is inspect.Parameter.VAR_POSITIONAL:
            slots = found
        elif parameter.kind is inspect.Parameter.VAR_KEYWORD:
            slots = found.values()
        if parameter.annotation is not inspect.Parameter.empty:
            for slot in slots:
                slot.hint = parameter.annotation


def _check_result(signature: inspect.Signature, method: Method, fitting: Fitting) -> None:
    returned = signature.return_annotation
    if method.result is None or returned is inspect.Signature.empty:
        return
    if not fitting.gives(returned, method.result):
        raise SignatureMismatch(f"it returns `{type_name(returned)}`, not `{annotation_for(method.result)}`")
