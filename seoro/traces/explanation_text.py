"""Text of the explanation in the last record of a trace; malformed parts are skipped."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from seoro.traces.reader import shown

_VERBS = {"waits": "waiting", "runs": "running", "holds": "held"}


def explanation_lines(explanation: object) -> Iterator[str]:
    """Yield lines about the activities at the time of the verdict."""
    found = _fields(explanation)
    if found.get("path"):
        yield f"at {_time(found.get('t'))} in {shown(found['path'])}"
    yield from _values(found)
    for activity in map(_fields, _items(found, "activities")):
        verb = _VERBS.get(str(activity.get("kind")), "active")
        since, text, source = (activity.get(name) for name in ("since", "text", "source"))
        yield f"{verb} since {_time(since)}: `{shown(text)}` ({shown(source)})"
        yield from (f"  {line}" for line in _values(activity))
        for emitter in map(_fields, _items(activity, "emitters")):
            last = emitter.get("last")
            reached = "was not reached" if last is None else f"was reached at {_time(last)}"
            yield f"  `{shown(emitter.get('text'))}` ({shown(emitter.get('source'))}) {reached}"


def _values(found: dict[str, Any]) -> Iterator[str]:
    for value in map(_fields, _items(found, "values")):
        if "error" in value:
            yield f"{shown(value.get('text'))} has no value: {shown(value['error'])}"
        else:
            yield f"{shown(value.get('text'))} = {shown(value.get('shown', value.get('value')))}"


def _fields(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}


def _items(found: dict[str, Any], name: str) -> list[Any]:
    value = found.get(name)
    return value if isinstance(value, list) else []


def _time(value: object) -> str:
    return f"{value:.3f} s" if isinstance(value, int | float) else "?"
