"""Files of any content: readable records are shown, and no command raises."""

import io
import json

from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic_core import from_json

from seoro.traces.perfetto import trace_events
from seoro.traces.reader import Filter, InvalidRecord, parse_line, read_trace, select
from seoro.traces.summary import summarise
from seoro.traces.summary_text import summary_lines
from seoro.traces.timeline import timeline
from tests.traces.test_perfetto import check_format

ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=4,
)
NAMES = (
    "id", "parent", "type", "name", "path", "source", "status", "reason", "arguments", "value", "level", "message",
    "item", "unit", "scenario", "file", "seed", "parameters", "clock", "duration",
)  # fmt: skip
KINDS = (
    "run.start", "behavior.start", "behavior.end", "event", "variable", "log", "cover", "record", "run.end", "new"
)  # fmt: skip
PARTS = ("t", "path", "kind", "since", "text", "source", "last", "unit", "error", "value")
EXPLANATION = st.recursive(
    st.dictionaries(st.sampled_from(PARTS), ANYTHING, max_size=4),
    lambda inner: st.dictionaries(
        st.sampled_from(["activities", "values", "emitters"]), st.lists(inner | ANYTHING, max_size=2), max_size=2
    ),
    max_leaves=4,
)
PLAUSIBLE = st.fixed_dictionaries(
    {
        "t": st.floats(0, 10),
        "kind": st.sampled_from(KINDS),
        "id": st.integers(0, 3),
        "parent": st.none() | st.integers(0, 3),
        "type": st.sampled_from(["serial", "parallel", "modifier", "action", "wait"]),
        **dict.fromkeys(
            ("name", "path", "source", "status", "reason", "level", "message", "item"), st.text(max_size=3)
        ),
        **dict.fromkeys(("scenario", "file"), st.text(max_size=3)),
    },
    optional={
        **dict.fromkeys(("arguments", "value", "unit", "seed", "clock"), ANYTHING),
        "explanation": ANYTHING | EXPLANATION,
    },
)
ANY_RECORD = st.dictionaries(st.sampled_from(NAMES), ANYTHING) | ANYTHING


@settings(max_examples=60, deadline=None)
@given(st.lists(PLAUSIBLE | ANY_RECORD, max_size=12))
def test_anything_is_shown_summed_up_and_converted(records: list[object]) -> None:
    file = io.BytesIO(b"".join(json.dumps(record).encode() + b"\n" for record in records))
    found = [record for record in read_trace(file) if isinstance(record, dict)]
    for line in timeline(select(found, Filter(paths=["*"])), is_whole=True):
        str(line)
    summary = summarise(found, [])
    json.dumps(summary.plain())
    assert list(summary_lines(summary))
    in_order = sorted(found, key=lambda record: record["t"])
    check_format(list(trace_events(in_order)))


@settings(max_examples=50, deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_read(data: bytes) -> None:
    assert all(isinstance(each, dict | InvalidRecord) for each in read_trace(io.BytesIO(data)))


JSON_TEXT = ANYTHING.map(json.dumps).map(str.encode)


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_the_faster_parser_accepts_what_the_parser_of_python_accepts(data: st.DataObject) -> None:
    line = data.draw(JSON_TEXT)
    at = data.draw(st.integers(0, len(line)))
    line = line[:at] + data.draw(st.binary(max_size=3)) + line[at + data.draw(st.integers(0, 3)) :]
    try:
        found = from_json(line)
    except ValueError:
        return  # the other one decides
    assert repr(found) == repr(parse_line(line))  # NaN does not equal itself
