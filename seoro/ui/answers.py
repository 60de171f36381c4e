"""Answers with JSON data, and errors as `{"error": "...", "help": "..."}`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from seoro.errors import BackendError, SeoroError, UsageError, cause_of
from seoro.files.inputs import failure_reason
from seoro.runtime.trace.jsonl import to_json

_REASONS: Final = {404: "not found", 405: "this path does not support the method"}
_TYPE: Final = "application/json"


def answer(data: object, status: int = 200) -> Response:
    """Make an answer of JSON data."""
    return Response(to_json(data).encode("utf-8", "backslashreplace"), status, media_type=_TYPE)


class RequestError(Exception):
    """An error of a request.

    Args:
        status: Status code of HTTP.
        error: Description of the error.
        help: Suggestion for a fix.
        field: Name of the form's field at fault.
    """

    def __init__(self, status: int, error: str, help: str = "", field: str = "") -> None:  # noqa: A002
        super().__init__(error)
        self.status = status
        self.error = error
        self.help = help
        self.field = field

    @property
    def data(self) -> dict[str, str]:
        """JSON data of the answer."""
        field = {"field": self.field} if self.field else {}
        return {"error": self.error, "help": self.help, **field}


def as_request_error(error: Exception, field: str = "") -> RequestError:
    """Convert an exception; those of seoro keep their text."""
    error = cause_of(error)
    match error:
        case RequestError():
            return error
        case UsageError():
            return RequestError(400, error.message if error.span is None else str(error), error.help, field)
        case BackendError():
            return RequestError(503, str(error), getattr(error, "help", ""), field)
        case OSError():
            reason = failure_reason(error)
            return RequestError(500, f"{error.filename}: {reason}" if error.filename else reason, "", field)
        case SeoroError():
            return RequestError(400, str(error), "", field)
        case _:
            return RequestError(500, f"internal error: {type(error).__name__}: {error}", "", field)


async def answer_error(_: Request, error: Exception) -> Response:
    """Answer a request that raised an exception."""
    if isinstance(error, HTTPException):
        found = RequestError(error.status_code, _REASONS.get(error.status_code, error.detail))
    else:
        found = as_request_error(error)
    return answer(found.data, found.status)


async def read_object(request: Request, *names: str) -> dict[str, Any]:
    """Read the JSON object in the body of a request; an empty body is an empty object.

    Args:
        request: The request.
        names: Names of the fields that it may have.

    Raises:
        RequestError: The body is not a JSON object, or has an unknown field.
    """
    body = await request.body()
    if not body:
        return {}
    try:
        found = await request.json()
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise RequestError(400, "invalid body of the request", "expected a JSON object")
    for name in found:
        if name not in names:
            expected = f"fields: {', '.join(names)}" if names else "the request has no fields"
            raise RequestError(400, f"unknown field `{name[:100]}`", expected, field=name)
    return found


def text_of(data: Mapping[str, Any], name: str, default: str = "") -> str:
    """Return a text of a JSON object.

    Raises:
        RequestError: The value is not a text.
    """
    found = data.get(name)
    if found is None:
        return default
    if not isinstance(found, str):
        raise RequestError(400, f"invalid `{name}`: expected a text", field=name)
    return found
