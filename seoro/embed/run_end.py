"""Serialisation of the end of a run, so that another process can print and write its result like a local one.

Verdicts and messages are trees of frozen values with places in texts. They are packed by their fields, each text
once, and unpacked by the declared types of their classes. So bytes from other machines become valid values, or are
refused.
"""

from __future__ import annotations

import types
from collections.abc import Mapping
from enum import Enum
from functools import cache
from typing import Any, Final, TypeAlias, Union, get_args, get_origin, get_type_hints

import msgpack

from seoro.bridges.wire.limits import MAX_MESSAGE, Limits, check_limits
from seoro.errors import BackendError, BackendUnreachable, InvalidScenario, SeoroError, UsageError
from seoro.lang.diagnostic import Diagnostic
from seoro.lang.frozen import Frozen, Value
from seoro.lang.source import SourceFile, Span
from seoro.runtime.verdict import Verdict

MAX_DEPTH: Final = 50  # of nested values
_UNIONS: Final = (Union, types.UnionType)


class ResultFile(Value):
    """Output file of a run.

    Args:
        path: Path in the output folder.
        description: Description for people.
        is_artifact: Whether it is from the simulator; otherwise it is from an action.
    """

    path: str
    description: str
    is_artifact: bool = False


class Ended(Value):
    """End of a run with a verdict.

    Args:
        verdict: The verdict.
        parameters: The chosen value of every parameter, as JSON data.
        files: Files in its output folder.
        fault: Location of an exception in an action's code that ended the run, in one line; may be empty.
        traceback: Traceback of that exception.
    """

    verdict: Verdict
    parameters: object
    files: tuple[ResultFile, ...]
    fault: str
    traceback: str


class UsageFault(Value):
    """Fields of a `UsageError` that refused a run."""

    message: str
    span: Span | None
    help: str
    places: tuple[tuple[Span, str], ...]
    code: str


class NotStarted(Value):
    """End of a run that did not start.

    Args:
        diagnostics: Errors of the scenario.
        misuse: Error of the options.
        backend: Error of a simulator or a bridge.
        help: Suggestion how to start an unreachable one.
    """

    diagnostics: tuple[Diagnostic, ...] = ()
    misuse: UsageFault | None = None
    backend: str = ""
    help: str = ""

    @property
    def error(self) -> SeoroError:
        """The exception that a run in this process would have raised."""
        if self.misuse is not None:
            misuse = self.misuse
            return UsageError(misuse.message, misuse.span, misuse.help, misuse.places, misuse.code)
        if self.diagnostics:
            return InvalidScenario(self.diagnostics)
        return BackendUnreachable(self.backend, self.help) if self.help else BackendError(self.backend)


End: TypeAlias = Ended | NotStarted
_PACKED: Final = tuple[Ended | None, NotStarted | None]  # one of them

LIMITS: Final = Limits(MAX_MESSAGE, 1_000_000, 1000)  # of the bytes of an end


class InvalidEnd(Exception):
    """The bytes are not a valid end of a run."""


def not_started(error: SeoroError) -> NotStarted:
    """Convert the exception that kept a run from starting."""
    match error:
        case InvalidScenario(diagnostics=diagnostics):
            return NotStarted(diagnostics=diagnostics)
        case UsageError():
            return NotStarted(misuse=UsageFault(error.message, error.span, error.help, error.places, error.code))
        case BackendUnreachable():
            return NotStarted(backend=str(error), help=error.help)
        case _:
            return NotStarted(backend=str(error))


def pack_end(end: End) -> bytes:
    """Serialise the end of a run."""
    files: dict[SourceFile, int] = {}
    content = _pack((end, None) if isinstance(end, Ended) else (None, end), files)
    texts = [[file.name, file.text] for file in files]
    packed: bytes = msgpack.packb([texts, content], unicode_errors="surrogatepass")
    return packed


def unpack_end(data: bytes) -> End:
    """Deserialise the end of a run.

    Raises:
        InvalidEnd: The bytes are invalid.
    """
    try:
        check_limits(data, LIMITS)
        texts, content = msgpack.unpackb(data, unicode_errors="surrogatepass")
        files = tuple(SourceFile(_of(str, name), _of(str, text)) for name, text in texts)
        ended, refused = _unpack(_PACKED, content, files, 0)
    except (ValueError, TypeError, msgpack.UnpackException) as error:
        raise InvalidEnd(f"invalid end of a run: {error}") from error
    end: End | None = ended or refused
    if end is None:
        raise InvalidEnd("invalid end of a run: neither a verdict nor an error")
    return end


def _pack(value: Any, files: dict[SourceFile, int]) -> Any:
    match value:
        case SourceFile():
            return files.setdefault(value, len(files))
        case Enum():
            return value.value
        case Frozen():
            return [_pack(getattr(value, name), files) for name in value.__match_args__]
        case tuple() | list():
            return [_pack(part, files) for part in value]
        case Mapping():
            return {str(key): _pack(part, files) for key, part in value.items()}
        case None | bool() | int() | float() | str():
            return value
        case _:
            raise TypeError(f"{type(value).__name__} cannot be part of the end of a run")


def _unpack(kind: Any, value: Any, files: tuple[SourceFile, ...], depth: int) -> Any:
    if depth > MAX_DEPTH:
        raise ValueError(f"more than {MAX_DEPTH} nested values")
    origin = get_origin(kind)
    if kind in (object, Any):
        return value
    if origin in _UNIONS:
        [inner] = (each for each in get_args(kind) if each is not types.NoneType)
        return None if value is None else _unpack(inner, value, files, depth)
    if origin is tuple:
        return _unpack_tuple(get_args(kind), _of(list, value), files, depth)
    if kind is SourceFile:
        index = _of(int, value)
        if not 0 <= index < len(files):
            raise ValueError(f"unknown text {index}")
        return files[index]
    if issubclass(kind, Enum):
        return kind(value)
    if issubclass(kind, Frozen):
        return _unpack_fields(kind, _of(list, value), files, depth)
    return _of(kind, value)


def _unpack_tuple(
    kinds: tuple[Any, ...], values: list[Any], files: tuple[SourceFile, ...], depth: int
) -> tuple[Any, ...]:
    if len(kinds) == 2 and kinds[1] is Ellipsis:
        kinds = (kinds[0],) * len(values)
    return tuple(_unpack(kind, part, files, depth + 1) for kind, part in zip(kinds, values, strict=True))


def _unpack_fields(kind: type[Frozen], values: list[Any], files: tuple[SourceFile, ...], depth: int) -> Frozen:
    names, hints = kind.__match_args__, _hints(kind)
    if len(names) != len(values):
        raise ValueError(f"{kind.__name__} has {len(names)} fields, not {len(values)}")
    fields = (_unpack(hints[name], part, files, depth + 1) for name, part in zip(names, values, strict=True))
    made = kind(*fields)
    if isinstance(made, Span) and not 0 <= made.start <= made.end <= len(made.file.text):
        raise ValueError("a place is outside of its text")
    return made


@cache
def _hints(kind: type[Frozen]) -> dict[str, Any]:
    return get_type_hints(kind)


def _of(kind: type, value: Any) -> Any:
    """Check the type of a value; integers are valid floats."""
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ValueError(f"expected {kind.__name__}, found {type(value).__name__}")
    return value
