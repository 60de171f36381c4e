"""Hypothesis strategies for programs: well-typed, with a bounded duration.

Programs take a few seconds, so that many events occur in one instant. Repetitions are bounded, and a timeout
surrounds the body.
"""

from __future__ import annotations

from hypothesis import strategies as st

from tests.generated.model import Behavior, Block, Line, Program, Scenario, Statement

_PLAIN = (
    "@one", "@two", "@sent", "@two if n > 0", "@sent as t if t.level == n", "@sent as t if t.level > 1",
    "@derived", "@one if elapsed(1s)", "@one if every(0.5s)", "@two if rise(n > 0)", "n == 2",
    "n >= 1 and seen < 2", "twice(n) == 4", "rise(n > 1)", "fall(n % 2 == 0)", "seen == 1",
    "every(1s, offset: 1s)", "every(0.7s)", "elapsed(0s)", "elapsed(0.5s)", "elapsed(1s)", "elapsed(2s)",
)  # fmt: skip
_LABELLED = (
    "@{any}.start", "@{any}.end", "@{any}.fail", "@{any}.end if n > 0", "@{worker}.one", "@{worker}.extra",
    "@{worker}.sent as t if t.level == 1", "{worker}.size == 2", "rise({worker}.n > 0)",
)  # fmt: skip
_DRAWN = ("elapsed([0s..2s])", "elapsed([1s..3s])")
_STATEMENTS = (
    'log("{number}")', "log(n)", "log(twice(seen))", "emit one", "emit two", "emit sent(1)", "emit sent(n)",
    "emit sent(level: n + 1)", "increment(n)", "decrement(n)", 'compare(n, "<", 2)', "call twice(n)", "hold()",
    "work(0s)", "work(1s)", "give_up()", "emit end", "emit fail",
)  # fmt: skip
_OPERATORS = (
    "serial", "parallel", "serial(duration: [0s..1s])", "serial(duration: 2s)", "parallel(duration: [1s..2s])",
    "parallel(overlap: equal)", "parallel(overlap: start)", "parallel(overlap: end)", "parallel(overlap: initial)",
    "parallel(overlap: final)", "parallel(overlap: inside)", "parallel(overlap: full)", "parallel(overlap: any)",
    "parallel(overlap: any, start_to_start: 1s)", "parallel(overlap: inside, start_to_start: 0.5s)",
    "parallel(overlap: initial, start_to_start: -1s)", "parallel(overlap: any, end_to_end: [-1s..1s])",
    "parallel(overlap: final, end_to_end: 1s)", "parallel(overlap: any, start_to_start: 0.5s, duration: [0s..2s])",
)  # fmt: skip
_DRAWN_OPERATORS = ("one_of", "one_of(duration: [0s..1s])", "parallel(overlap: any, start_to_start: [-1s..2s])")
_MODIFIERS = (
    "retry(2)", "repeat(2)", "repeat(3)", "inverter()", "timeout(0.5s)", "timeout(1s)", "failure_is_success()",
    "success_is_failure()", "failure_is_running()", "success_is_running()", "running_is_failure()",
    "running_is_success()", "patient(1s)", "anyhow()",
)  # fmt: skip
_INVOCATIONS = (
    ("inner()", ()),
    ("inner(duration: [0s..1s])", ()),
    ("worker()", ("keep(it.size == 2)", "keep(it.size == 1 or it.pace > 1s)", "paced(2s)")),
    ("worker(2)", ("paced(0.5s)",)),
    ("worker(size: n, pace: 0.5s)", ()),
    ("worker(duration: 1s)", ("keep(it.size == 2)",)),
)
_DRAWN_WITH = ("keep(it.size in [1..3])",)
_ON = "on {specification}:\n    {answer}"
_ANSWERS = ("emit one", "emit two", "emit sent(2)", "emit sent(n)", "call twice(n)", "emit end", "emit fail")
_MAX_LEAVES = 9
_PICKS = st.integers(0, 60)


def programs(drawn: bool = True) -> st.SearchStrategy[Program]:
    """Programs.

    Args:
        drawn: Whether anything in them is drawn from the seed, or decided by the order of the text.
    """
    return st.builds(
        Program,
        inner=_scenarios("inner", drawn, 3),
        worker=_scenarios("worker", drawn, 4),
        main=_scenarios("main", drawn, _MAX_LEAVES).map(_bounded),
    )


def _bounded(scenario: Scenario) -> Scenario:
    """The same beside something that goes on, and within a timeout."""
    going_on = "\n".join(("wait elapsed(1s)", "emit one", "wait elapsed(1s)", "emit two", "wait elapsed(1s)"))
    beside = Block("serial", tuple(Statement(Line(line)) for line in going_on.splitlines()))
    body = Block("parallel", (scenario.body, beside), (Line("timeout(6s)"),))
    return Scenario(body, scenario.extra, scenario.members)


def _scenarios(name: str, drawn: bool, leaves: int) -> st.SearchStrategy[Scenario]:
    specifications = _specifications(drawn)
    extra = st.sampled_from([line for line in _PLAIN if "as t" not in line]).map(Line)
    answers = st.tuples(specifications, st.sampled_from(_ANSWERS)).map(
        lambda part: _around(part[0], _ON.replace("{answer}", part[1]).replace("{specification}", "{}"), None)
    )
    samples = specifications.map(lambda line: _around(line, "var taken{number}: int = sample(n + 1, {}, 0)", None))
    modifiers = st.sampled_from([each for each in _MODIFIERS if "repeat" not in each]).map(Line)
    members = st.lists(st.one_of(answers, answers, samples, modifiers), max_size=2).map(tuple)
    return st.builds(Scenario, _behaviors(name, drawn, leaves), extra, members)


def _around(line: Line, template: str, instead: str | None) -> Line:
    """A line with another one, which is an event specification, in it."""
    return Line(template.replace("{}", line.template), line.pick, instead)


def _specifications(drawn: bool) -> st.SearchStrategy[Line]:
    plain = (*_PLAIN, "@extra", *(_DRAWN if drawn else ()))
    return st.one_of(
        st.sampled_from(plain).map(Line),
        st.builds(Line, st.sampled_from(_LABELLED), _PICKS, st.just("@one")),
    )


def _behaviors(scenario: str, drawn: bool, leaves: int) -> st.SearchStrategy[Behavior]:
    """Strategy for the body of a scenario."""
    specifications = _specifications(drawn)
    waits = specifications.map(lambda line: _around(line, "wait {}", "wait @one"))
    if scenario == "main":
        waits |= st.sampled_from(("wait @gauge.tick", "wait gauge.ticks == 2")).map(Line)
    if scenario == "worker":
        waits |= st.sampled_from(("wait elapsed(pace)", "wait n == size")).map(Line)
    statements = st.one_of(waits, waits, st.sampled_from(_STATEMENTS).map(Line))
    leaf: st.SearchStrategy[Behavior] = st.builds(
        Statement, statements, st.sampled_from((False, False, False, True))
    )
    within = _within(specifications, drawn)
    invocable = {"inner": (), "worker": _INVOCATIONS[:2], "main": _INVOCATIONS}[scenario]
    if invocable:
        leaf = leaf | _invocations(invocable, within, drawn)
    operators = st.sampled_from((*_OPERATORS, *(_DRAWN_OPERATORS if drawn else ()), *("serial", "parallel") * 6))

    def grow(members: st.SearchStrategy[Behavior]) -> st.SearchStrategy[Behavior]:
        several = st.lists(members, min_size=1, max_size=3).map(tuple)
        return st.builds(Block, operators, several, within, st.booleans())

    return st.recursive(leaf, grow, max_leaves=leaves)


def _within(specifications: st.SearchStrategy[Line], drawn: bool) -> st.SearchStrategy[tuple[Line, ...]]:
    """Generate the lines of `with` blocks."""
    untils = specifications.map(lambda line: _around(line, "until {}", "until @one"))
    lines = st.one_of(st.sampled_from(_MODIFIERS).map(Line), untils)
    if drawn:  # if behaviors override each other, the first in the text continues
        overrides = st.sampled_from(("override({any}, {other})", "override({any}, {other}, when_active)"))
        lines |= st.builds(Line, overrides, _PICKS)
    return st.one_of(st.just(()), st.lists(lines, max_size=2).map(tuple))


def _invocations(
    invocable: tuple[tuple[str, tuple[str, ...]], ...], within: st.SearchStrategy[tuple[Line, ...]], drawn: bool
) -> st.SearchStrategy[Behavior]:
    def with_own(invocation: tuple[str, tuple[str, ...]]) -> st.SearchStrategy[Behavior]:
        head, own = invocation
        if drawn and own:
            own = (*own, *_DRAWN_WITH)
        first = st.lists(st.sampled_from(own), max_size=1) if own else st.just([])
        lines = st.tuples(first, within).map(lambda part: (*map(Line, part[0]), *part[1]))
        return st.builds(Block, st.just(head), st.just(()), lines, st.booleans())

    return st.sampled_from(invocable).flatmap(with_own)
