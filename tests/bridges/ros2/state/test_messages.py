"""Messages about the state of a run, from the records of its trace."""

from typing import Any

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.state.behaviors import ERROR, MOST, OK, STALE, BehaviorStates
from seoro.bridges.ros2.state.markers import RunMarkers

START = {"t": 0.0, "kind": "run.start", "scenario": "main", "file": "main.osc", "seed": 7, "clock": "real"}
POINT = {"object": 2, "types": ["position_3d"], "fields": {"x": 3.0, "y": -3.0, "z": 0.0}}
POSE = {
    "object": 1,
    "types": ["pose_3d"],
    "fields": {
        "position": POINT,
        "orientation": {"object": 3, "types": ["orientation_3d"], "fields": {"yaw": 1.0}},
    },
}


def started(number: int, name: str = "robot.nav_to_pose", kind: str = "action") -> dict[str, Any]:
    source = "main.osc:3:5"
    fields = {"id": number, "type": kind, "name": name, "path": f"main/{name}[{number}]", "source": source}
    return {"t": 1.0, "kind": "behavior.start", **fields}


def ended(number: int, status: str = "succeeded", reason: str = "") -> dict[str, Any]:
    return {"t": 2.0, "kind": "behavior.end", "id": number, "status": status, "reason": reason}


def given(number: int, **values: Any) -> dict[str, Any]:
    return {"t": 1.0, "kind": "instance", "behavior": number, "values": values}


def statuses(states: BehaviorStates) -> list[tuple[str, int, str]]:
    return [(each["name"], each["level"], each["message"]) for each in states.message(0)["status"]]


def test_the_tree_has_what_runs_and_how_it_ended() -> None:
    states = BehaviorStates("seoro_1")
    for record in (START, started(0), started(1), started(2), ended(1, "failed", "no way"), ended(2, "cancelled")):
        assert states.add(record)
    assert statuses(states) == [
        ("seoro", OK, "running"),
        ("seoro/main/robot.nav_to_pose[0]", OK, "running"),
        ("seoro/main/robot.nav_to_pose[1]", ERROR, "failed: no way"),
        ("seoro/main/robot.nav_to_pose[2]", STALE, "cancelled"),
    ]
    states.add({"t": 2.0, "kind": "run.end", "status": "failed", "reason": "no way", "duration": 2.0})
    assert statuses(states)[0] == ("seoro", ERROR, "failed: no way")
    facts = {each["key"]: each["value"] for each in states.message(0)["status"][0]["values"]}
    assert (facts["scenario"], facts["seed"], facts["duration [s]"]) == ("main", "7", "2.000")


def test_a_long_run_keeps_the_running_behaviors() -> None:
    states = BehaviorStates("seoro_1")
    for record in (START, started(0)):
        states.add(record)
    for number in range(1, 2 * MOST):
        states.add(started(number))
        states.add(ended(number))
    kept = [name for name, _, _ in statuses(states)]
    assert len(kept) == MOST + 1
    assert kept[1].endswith("[0]") and kept[-1].endswith(f"[{2 * MOST - 1}]")


def shown(markers: RunMarkers) -> dict[str, list[dict[str, Any]]]:
    """Return the markers that a viewer has after the messages so far, by namespace."""
    kept: dict[str, list[dict[str, Any]]] = {}
    for each in markers.message()["markers"]:
        if each.get("action") != 2:
            kept.setdefault(each["ns"], []).append(each)
    return kept


def test_goals_are_shown_while_their_action_runs() -> None:
    markers = RunMarkers()
    markers.add(started(4))
    assert markers.add(given(4, goal_pose=POSE, limit=3.0))
    arrow, text = shown(markers)["goals"]
    assert arrow["pose"]["position"] == {"x": 3.0, "y": -3.0, "z": 0.0}
    assert text["text"] == "robot.nav_to_pose"
    assert markers.add(ended(4))
    deleted = markers.message()["markers"]
    assert [(each["id"], each["action"]) for each in deleted] == [(arrow["id"], 2), (text["id"], 2)]
    assert not markers.message()["markers"]


def test_places_are_known_by_their_numbers() -> None:
    """Traces describe each object once."""
    markers = RunMarkers()
    markers.add(given(0, spot=POINT, way=[POSE]))  # of the scenario
    assert "goals" not in shown(markers)
    for number, value in ((5, {"object": 2}), (6, [{"object": 1}, {"object": 2}])):
        markers.add(started(number))
        assert markers.add(given(number, place=value))
    goals = [each for each in shown(markers)["goals"] if not each.get("text")]
    assert [each["pose"]["position"]["x"] for each in goals] == [3.0, 3.0, 3.0]
    assert [each["type"] for each in goals] == [2, 0, 2]  # spheres for positions, arrows for poses


def test_paths_are_replaced() -> None:
    markers = RunMarkers()
    for points in ([[0, 0], [1, 0]], [[0, 0], [2, 0]]):
        markers.add({"t": 1.0, "kind": "path", "entity": "tb", "points": points})
    (line,) = shown(markers)["paths"]
    assert [point["x"] for point in line["points"]] == [0.0, 2.0]
    markers.add({"t": 1.0, "kind": "path", "entity": "tb", "points": []})
    assert "paths" not in shown(markers)


def test_contacts_and_events_stay() -> None:
    markers = RunMarkers()
    contact = {"first": "tb", "second": "box", "position": [1.0, 2.0, 0.3]}
    assert markers.add({"t": 1.5, "kind": "event", "name": "contact", "arguments": contact})
    assert markers.add({"t": 2.5, "kind": "event", "name": "main.arrived", "event": "arrived", "arguments": {}})
    assert not markers.add({"t": 3.0, "kind": "event", "name": "main.end", "event": "end", "arguments": {}})
    for _ in range(2):
        found = shown(markers)
        assert [each.get("text") for each in found["contacts"]] == [None, "tb, box"]
        assert found["events"][0]["text"] == "1.500 s  contact\n2.500 s  main.arrived"


def test_messages_are_those_of_their_types(types: TypeStore) -> None:
    states, markers = BehaviorStates("seoro_1"), RunMarkers()
    contact = {"first": "tb", "second": "box", "position": [1.0, 2.0, 0.3]}
    for record in (
        START,
        started(0),
        given(0, goal=POSE),
        {"t": 1.0, "kind": "path", "entity": "tb", "points": [[0, 0], [1, 0]]},
        {"t": 1.5, "kind": "event", "name": "contact", "arguments": contact},
    ):
        states.add(record)
        markers.add(record)
    decoded = types.decode(
        "diagnostic_msgs/msg/DiagnosticArray", encoded(types, "diagnostic_msgs", states.message(5))
    )
    assert [each.message for each in decoded.status] == ["running", "running"]
    decoded = types.decode(
        "visualization_msgs/msg/MarkerArray", encoded(types, "visualization_msgs", markers.message())
    )
    numbers = [(each.ns, each.id) for each in decoded.markers]
    assert len(numbers) == len(set(numbers)) == 6


def encoded(types: TypeStore, package: str, values: dict[str, Any]) -> bytes:
    kind = {"diagnostic_msgs": "DiagnosticArray", "visualization_msgs": "MarkerArray"}[package]
    return types.encode(f"{package}/msg/{kind}", values)
