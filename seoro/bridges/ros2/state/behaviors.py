"""The tree of behaviors of a run as `diagnostic_msgs/msg/DiagnosticArray`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from seoro.bridges.ros2.recording.bag_values import Values, time_value

Record = Mapping[str, Any]

OK, ERROR, STALE = 0, 2, 3  # levels of a status
ROOT: Final = "seoro"  # name of the status of the run; those of its behaviors are below it
MOST: Final = 500  # statuses; beyond that, the oldest ended behaviors are left out
_LEVELS: Final = {"succeeded": OK, "passed": OK, "failed": ERROR, "error": ERROR, "cancelled": STALE}


class BehaviorStates:
    """States of the behaviors of a run.

    Args:
        source: Name of the node that publishes them.
    """

    def __init__(self, source: str) -> None:
        self._source = source
        self._run: Values = {}
        self._states: dict[int, Values] = {}  # by number, the latest last

    def add(self, record: Record) -> bool:
        """Add a record; returns whether a state changed."""
        match record["kind"]:
            case "run.start":
                facts = {name: record[name] for name in ("scenario", "file", "seed", "clock")}
                self._run = self._status(ROOT, OK, "running", facts)
            case "run.end":
                self._run = self._ended(self._run, record, {"duration [s]": f"{record['duration']:.3f}"})
            case "behavior.start":
                facts = {"type": record["type"], "source": record["source"], "start [s]": f"{record['t']:.3f}"}
                self._states[record["id"]] = self._status(f"{ROOT}/{record['path']}", OK, "running", facts)
                self._forget()
            case "behavior.end":
                if (state := self._states.pop(record["id"], None)) is not None:
                    self._states[record["id"]] = self._ended(state, record, {"end [s]": f"{record['t']:.3f}"})
            case _:
                return False
        return True

    def message(self, at: int) -> Values:
        """Return the message with the states of now.

        Args:
            at: Time since the epoch [ns].
        """
        return {
            "header": {"stamp": time_value(at)},
            "status": [self._run, *self._states.values()] if self._run else [],
        }

    def _ended(self, state: Values, record: Record, facts: Mapping[str, object]) -> Values:
        reason = f": {record['reason']}" if record["reason"] else ""
        return state | {
            "level": _LEVELS[record["status"]],
            "message": f"{record['status']}{reason}",
            "values": [*state["values"], *_pairs(facts)],
        }

    def _forget(self) -> None:
        """Leave out the behaviors that ended first."""
        for number in [*self._states] if len(self._states) > MOST else ():
            if self._states[number]["message"] != "running":
                del self._states[number]
            if len(self._states) <= MOST:
                return

    def _status(self, name: str, level: int, message: str, facts: Mapping[str, object]) -> Values:
        return {
            "level": level,
            "name": name,
            "message": message,
            "hardware_id": self._source,
            "values": _pairs(facts),
        }


def _pairs(facts: Mapping[str, object]) -> list[Values]:
    return [{"key": key, "value": str(value)} for key, value in facts.items()]
