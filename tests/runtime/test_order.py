"""The textual order of parallel members changes nothing (semantics of rounds), whatever the scenario."""

import asyncio
import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from seoro.embed import Options, load, prepare
from seoro.runtime.verdict import RunStatus

# A behavior is a statement, or an operator with its members and modifiers.
Behavior = str | tuple[str, tuple["Behavior", ...], tuple[str, ...]]

EVENTS = ("one", "two")
SPECIFICATIONS = (
    "@one",
    "@two if n > 0",
    "@derived",
    "@latest.ready",
    "n == 2",
    "rise(n > 1)",
    "fall(n % 2 == 0)",
    "seen == 1",
    "every(1s, offset: 1s)",
    "elapsed(1s)",
)
OPERATORS = [
    "serial",
    "parallel",
    "parallel",
    "serial(duration: [0s..1s])",
    "parallel(duration: [1s..2s])",
    "parallel(overlap: equal)",
    "parallel(overlap: final)",
    "parallel(overlap: any, start_to_start: 1s)",
]
MODIFIERS = ["retry(2)", "repeat(2)", "inverter()", "timeout(1s)", "failure_is_success()", "running_is_success()"]
LEAVES = st.one_of(
    st.just("log"),
    st.sampled_from(["wait elapsed(0s)", "wait elapsed(1s)", "wait elapsed(2s)", "emit end"]),
    st.sampled_from([f"emit {event}" for event in EVENTS]),
    st.sampled_from([f"wait @{event}" for event in EVENTS]),
    st.sampled_from(["inner()", "increment(n)", "increment(n)", "call note(n)"]),
    st.sampled_from([f"wait {specification}" for specification in SPECIFICATIONS]),
)
UNTIL = [f"until {specification}" for specification in SPECIFICATIONS]


def grow(members: st.SearchStrategy[Behavior]) -> st.SearchStrategy[Behavior]:
    several = st.lists(members, min_size=1, max_size=3).map(tuple)
    modifiers = st.one_of(st.just(()), st.lists(st.sampled_from([*MODIFIERS, *UNTIL]), max_size=2).map(tuple))
    return st.tuples(st.sampled_from(OPERATORS), several, modifiers)


BEHAVIORS: st.SearchStrategy[Behavior] = st.recursive(LEAVES, grow, max_leaves=14)


def lines(behavior: Behavior, indent: int, names: Iterator[int], mirrored: bool) -> list[str]:
    """The text of a behavior; mirrored, with the members of each `parallel` in reverse order.

    Where its first member is the primary one, that stays the first.
    """
    blank = " " * indent
    if isinstance(behavior, str):
        return [f'{blank}log("{next(names)}")' if behavior == "log" else f"{blank}{behavior}"]
    operator, members, modifiers = behavior
    texts = [lines(member, indent + 4, names, mirrored) for member in members]
    if mirrored and operator.startswith("parallel"):
        primary = 1 if "overlap" in operator else 0
        texts[primary:] = reversed(texts[primary:])
    within = [f"{blank}with:", *(f"{blank}    {modifier}" for modifier in modifiers)] if modifiers else []
    return [f"{blank}{operator}:", *itertools.chain.from_iterable(texts), *within]


def scenario(behavior: Behavior, mirrored: bool) -> str:
    body = lines(
        ("parallel", (behavior, ("serial", ("wait elapsed(0s)", "latest: worker()"), ())), ()),
        4,
        itertools.count(),
        mirrored,
    )
    return "\n".join(
        [
            "import osc.types",
            "import osc.helpers",
            "scenario inner:",
            "    do parallel:",
            "        serial:",
            "            wait elapsed(1s)",
            "            emit end",
            "        wait elapsed(5s)",
            "scenario worker:",
            "    event ready",
            "    do serial:",
            "        emit ready",
            "        wait elapsed(1s)",
            "scenario main:",
            *(f"    event {event}" for event in EVENTS),
            "    event derived is @one if n % 2 == 1",
            "    event told",
            "    var n: int = 0",
            "    var seen: int = sample(n, @two, 0)",
            "    def note(k: int) -> int is expression k",
            "    on @two if n == 1:",
            "        emit told",
            "    on @told:",
            "        emit one",
            "    on n == 3:",
            "        emit two",
            "    do " + "\n".join(body).strip(),
            "",
        ]
    )


def outcome(text: str) -> Any:
    """What of a run must not depend on the order of members: its verdict, its length, what was logged when."""

    async def run() -> Any:
        async with prepare(load(path), Options(seed=0, clock="virtual")) as started, started.running():
            verdict = await started.result()
            records = [record async for record in started.trace()]
        # Of two things that end the run in one round the first in the text is named as the reason.
        status = "stuck" if "nothing can happen" in verdict.reason else verdict.status
        logs = sorted((r["t"], r["message"]) for r in records if r["kind"] == "log")
        variables = [(r["t"], r["path"], r["value"]) for r in records if r["kind"] == "variable"]
        return status, verdict.duration, logs, variables

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "test.osc"
        path.write_text(text)
        return asyncio.run(asyncio.wait_for(run(), 10))


@settings(max_examples=100, deadline=None, derandomize=True)
@given(BEHAVIORS)
def test_the_order_of_parallel_members_changes_nothing(behavior: Behavior) -> None:
    forward = outcome(scenario(behavior, mirrored=False))
    assert forward == outcome(scenario(behavior, mirrored=True))
    assert forward[0] in (RunStatus.PASSED, RunStatus.FAILED, "stuck")
