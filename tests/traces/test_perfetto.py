"""Chrome trace events: the rules of the document "Trace Event Format" (Google, Trace Viewer)."""

import io
import json
from typing import Any

import pytest

from seoro.traces.perfetto import write_perfetto

Trace = list[dict[str, Any]]


def convert(records: Trace) -> list[dict[str, Any]]:
    file = io.StringIO()
    number = write_perfetto(records, file)

    def refuse(constant: str) -> None:
        raise AssertionError(constant)

    document = json.loads(file.getvalue(), parse_constant=refuse)
    assert document["displayTimeUnit"] in ("ms", "ns")
    events: list[dict[str, Any]] = document["traceEvents"]
    assert len(events) == number
    return events


def check_format(events: list[dict[str, Any]]) -> None:
    """Check each event, and the nesting of slices on each track, against the format."""
    open_slices: dict[tuple[int, int], list[float]] = {}
    for event in events:
        assert event["ph"] in ("B", "E", "i", "C", "M"), event
        assert isinstance(event["pid"], int) and isinstance(event["tid"], int)
        assert isinstance(event["ts"], int | float) and event["ts"] >= 0  # microseconds
        assert isinstance(event.get("args", {}), dict)
        track = open_slices.setdefault((event["pid"], event["tid"]), [])
        match event["ph"]:
            case "B":
                assert isinstance(event["name"], str)
                assert not track or track[-1] <= event["ts"]
                track.append(event["ts"])
            case "E":
                assert track.pop() <= event["ts"]
            case "i":
                assert isinstance(event["name"], str)
                assert event["s"] in ("g", "p", "t")
            case "C":
                assert event["args"] and all(isinstance(value, float) for value in event["args"].values())
            case "M":
                assert event["name"] in ("process_name", "thread_name", "thread_sort_index")
                key = "sort_index" if event["name"] == "thread_sort_index" else "name"
                assert isinstance(event["args"][key], int if key == "sort_index" else str)
    assert not any(open_slices.values()), "slices without an end"


def test_the_document_follows_the_format(trace: Trace) -> None:
    check_format(convert(trace))


@pytest.mark.parametrize("length", [1, 5, 20, 30])
def test_so_does_that_of_a_run_that_was_killed(trace: Trace, length: int) -> None:
    check_format(convert(trace[:length]))


def test_values_of_other_writers_give_valid_json(trace: Trace) -> None:
    strange = [
        {"t": 6.0, "kind": "variable", "path": "x", "value": float("nan")},
        {"t": 6.0, "kind": "event", "name": "e", "arguments": {"a": [float("inf")]}},
    ]
    check_format(convert([*trace, *strange]))


def test_members_of_a_parallel_have_tracks_of_their_own(trace: Trace) -> None:
    events = convert(trace)
    tracks = {e["tid"]: e["args"]["name"] for e in events if e["ph"] == "M" and e["name"] == "thread_name"}
    assert list(tracks.values()) == [
        "events and logs",
        "main flow",
        "main/parallel[0]/serial[0]",
        "main/parallel[0]/serial[1]",
        "main/parallel[0]/nap[2]",
    ]
    waits = [event for event in events if event["ph"] == "B" and event["name"] == "wait"]
    assert len({event["tid"] for event in waits}) == 3


def test_the_timeline_contains_all_records(trace: Trace) -> None:
    events = convert(trace)
    assert [e["args"] for e in events if e["ph"] == "C"] == [{"value": 1.0}]
    named = {event["name"]: event["ts"] for event in events if event["ph"] == "i"}
    assert named["@main.go"] == named["gone"] == 1e6
    assert named["run failed"] == 5e6
    assert "level" in named
