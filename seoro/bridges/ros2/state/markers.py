"""Goals, paths, events and contacts of a run as `visualization_msgs/msg/MarkerArray`."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from typing import Any, Final

from seoro.bridges.ros2.recording.bag_values import MAP, Values, pose_value, vector
from seoro.bridges.ros2.recording.markers import DELETE
from seoro.bridges.ros2.state.places import Places

Record = Mapping[str, Any]

_ARROW, _SPHERE, _LINE, _TEXT = 0, 2, 4, 9  # kinds of markers
_UNTURNED: Final = (0.0, 0.0, 0.0, 1.0)
_GOAL: Final = (0.0, 0.62, 0.45, 0.9)  # red, green, blue, alpha; distinct with color blindness
_PATH: Final = (0.0, 0.45, 0.7, 0.9)
_CONTACT: Final = (0.84, 0.37, 0.0, 0.9)
_PLAIN: Final = (0.5, 0.5, 0.5, 1.0)
_ABOVE: Final = 0.3  # [m] of texts above their places
_EVENTS_AT: Final = (0.0, 0.0, 2.0)  # [m]; events have no place
_EVENTS: Final = 5  # shown at a time
_CONTACTS: Final = 200  # shown at a time
_TEXT_HEIGHT: Final = 0.15  # [m]
_CONTACT_EVENT: Final = "contact"
_DERIVED: Final = ("start", "end", "fail")  # events of all invocations, which behaviors show


class RunMarkers:
    """Markers of a run, and those to delete. Their frame is `map`."""

    def __init__(self) -> None:
        self._places = Places()
        self._names: dict[int, str] = {}  # of running actions
        self._goals: dict[int, list[Values]] = {}  # by the number of the action
        self._paths: dict[str, list[Values]] = {}  # by robot
        self._contacts: deque[list[Values]] = deque()
        self._events: deque[str] = deque(maxlen=_EVENTS)
        self._numbers = count()
        self._deleted: list[Values] = []

    def add(self, record: Record) -> bool:
        """Add a record; returns whether a marker changed."""
        match record["kind"]:
            case "behavior.start" if record["type"] == "action":
                self._names[record["id"]] = record["name"]
            case "instance":
                return self._start_goal(record)
            case "behavior.end":
                self._names.pop(record["id"], None)
                return self._delete(self._goals.pop(record["id"], []))
            case "path":
                self._delete(self._paths.pop(record["entity"], []))
                if record["points"]:
                    points = [vector(x, y, 0.0) for x, y in record["points"]]
                    line = self._marker("paths", _LINE, (0.0, 0.0, 0.05), (0.03, 0.0, 0.0), _PATH)
                    self._paths[record["entity"]] = [line | {"points": points}]
                return True
            case "event":
                return self._add_event(record)
        return False

    def message(self) -> Values:
        """Return the message with the markers of now, and those deleted since the last one."""
        deleted, self._deleted = self._deleted, []
        events = self._marker("events", _TEXT, _EVENTS_AT, (0.0, 0.0, _TEXT_HEIGHT), _PLAIN)
        shown = [events | {"id": 0, "text": "\n".join(self._events)}] if self._events else []
        groups = (*self._goals.values(), *self._paths.values(), *self._contacts)
        return {"markers": [*deleted, *(marker for group in groups for marker in group), *shown]}

    def _start_goal(self, record: Record) -> bool:
        markers = [
            marker
            for place in self._places.of(record["values"])
            for marker in self._goal(place.pose, self._names.get(record["behavior"]), is_pose=place.is_pose)
        ]
        if record["behavior"] not in self._names or not markers:  # of a scenario
            return False
        self._goals[record["behavior"]] = markers
        return True

    def _goal(self, pose: Sequence[float], name: str | None, *, is_pose: bool) -> Iterator[Values]:
        kind, scale = (_ARROW, (0.4, 0.06, 0.06)) if is_pose else (_SPHERE, (0.12, 0.12, 0.12))
        yield self._marker("goals", kind, pose, scale, _GOAL)
        yield self._text("goals", pose, name or "")

    def _add_event(self, record: Record) -> bool:
        if record["name"] == _CONTACT_EVENT:
            arguments = record["arguments"]
            place = arguments["position"]
            size = (0.1, 0.1, 0.1)
            text = f"{arguments['first']}, {arguments['second']}"
            ball = self._marker("contacts", _SPHERE, place, size, _CONTACT)
            self._contacts.append([ball, self._text("contacts", place, text)])
            if len(self._contacts) > _CONTACTS:
                self._delete(self._contacts.popleft())
        elif record.get("event") in _DERIVED:
            return False
        self._events.append(f"{record['t']:.3f} s  {record['name']}")
        return True

    def _text(self, group: str, place: Sequence[float], text: str) -> Values:
        x, y, z, *_ = place
        return self._marker(group, _TEXT, (x, y, z + _ABOVE), (0.0, 0.0, _TEXT_HEIGHT), _PLAIN) | {"text": text}

    def _marker(
        self, group: str, kind: int, place: Sequence[float], scale: Sequence[float], color: Sequence[float]
    ) -> Values:
        """Return a new marker; without a stamp, viewers use the latest transforms."""
        return {
            "header": {"frame_id": MAP},
            "ns": group,
            "id": next(self._numbers),
            "type": kind,
            "pose": pose_value((*place, *_UNTURNED)),  # a place may have a direction of its own
            "scale": vector(*scale),
            "color": dict(zip("rgba", color, strict=True)),
        }

    def _delete(self, markers: Sequence[Values]) -> bool:
        self._deleted += [marker | {"action": DELETE} for marker in markers]
        return bool(markers)
