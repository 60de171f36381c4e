"""Scenarios that together have every construct, for runs that are cancelled at each of their wake-ups."""

from __future__ import annotations

from typing import Final

INVOKED: Final = """
scenario nap:
    length: time
    event half
    do serial:
        wait elapsed(length / 2)
        emit half
        wait elapsed(length / 2)

scenario broken:
    do serial:
        wait elapsed(1s)
        emit fail

action hold
action clean
action ask
action keep_open

actor robot:
    var count: int = 0

action robot.move

modifier patience of nap:
    event half_way is @it.half
    event last(n: int)
    var n: int = sample(n + 1, @tick, 0)
    event tick is every(0.5s, offset: 0.5s)
    on @half_way:
        emit last(n)
    on @end:
        emit last(n)

"""

# Bodies of the scenario `main` by topic, indented by four spaces.
BODIES: Final = {
    "serial": """
do serial:
    log("a")
    wait elapsed(1s)
    nap(1s)
    log("b")
""",
    "serial that fails": """
do serial:
    nap(1s)
    broken()
    log("never")
""",
    "parallel": """
do parallel:
    wait elapsed(2s)
    nap(3s)
    log("at once")
""",
    "parallel in parallel": """
do parallel:
    parallel:
        nap(1s)
        serial:
            parallel:
                nap(1s)
                wait elapsed(2s)
            hold()
    clean()
with:
    timeout(3s)
""",
    "parallel with a failing member": """
do parallel:
    broken()
    clean()
    nap(4s)
""",
    "parallel with offsets": """
do parallel(overlap: any, start_to_start: [0.5s..1s]):
    nap(2s)
    nap(1s)
    clean() with:
        timeout(1s)
""",
    "parallel of equal ends": """
do parallel(overlap: equal):
    nap(2s)
    hold()
    log("done") with:
        success_is_running()
""",
    "parallel that ends later": """
do parallel(overlap: final, end_to_end: 1s):
    nap(1s)
    hold()
""",
    "parallel of many": """
do parallel:
    nap(1s)
    nap(2s)
    nap(1s)
    nap(2s)
    nap(1s)
    nap(3s)
    clean() with:
        timeout(2s)
        inverter()
""",
    "one_of": """
do one_of:
    nap(1s)
    nap(2s)
""",
    "one_of with guards": """
event go
do parallel:
    one_of:
        serial:
            wait @go
            nap(1s)
        serial:
            wait @go
            log("never")
        serial:
            wait elapsed(9s)
            log("never")
        clean()
    serial:
        wait elapsed(1s)
        emit go
""",
    "one_of that fails": """
do one_of:
    broken()
    broken()
""",
    "wait for an event": """
event go(k: int)
do parallel:
    serial:
        wait @go as g if g.k == 2
        wait @go
    serial:
        emit go(1)
        wait elapsed(1s)
        emit go(2)
        wait elapsed(1s)
        emit go(3)
""",
    "wait for a condition": """
var n: int = 0
do parallel:
    wait n == 2
    wait rise(n > 0)
    serial:
        increment(n)
        wait elapsed(1s)
        increment(n)
""",
    "wait for times": """
do serial:
    wait every(1s, offset: 0.5s)
    wait elapsed([0.1s..0.9s])
""",
    "wait for the end of a label": """
do parallel:
    a: nap(2s)
    wait @a.half
    wait @a.end
""",
    "derived events": """
event go
event later is @go
event last is elapsed(2s)
do parallel:
    wait @later
    wait @last
    emit go
""",
    "until": """
event go
do parallel:
    nap(9s) with:
        until @go
    serial:
        wait elapsed(1s)
        emit go
""",
    "until that holds": """
event go
do parallel:
    log("done") with:
        until @go
        until elapsed(5s)
    serial:
        wait elapsed(2s)
        emit go
""",
    "until around clean-up": """
do clean() with:
    until elapsed(1s)
""",
    "until within until": """
do serial:
    serial:
        clean() with:
            until elapsed(2s)
        log("after")
    with:
        until elapsed(1s)
    log("last")
""",
    "emit": """
event a
event b
on @a:
    emit b
do parallel:
    wait @b
    emit a
""",
    "emit end": """
do parallel:
    clean()
    serial:
        wait elapsed(1s)
        emit end
""",
    "emit fail": """
do parallel:
    clean()
    serial:
        wait elapsed(1s)
        emit fail
""",
    "on": """
event answer(n: int)
var n: int = 0
on every(0.5s):
    emit answer(n)
on rise(n == 1):
    emit answer(10)
do serial:
    increment(n)
    wait elapsed(1.2s)
""",
    "sample": """
event go
var n: int = sample(n + 1, @go, 0)
var double: int = sample(2 * n, every(1s), 0)
do serial:
    emit go
    wait elapsed(1s)
    emit go
    wait n == 2
""",
    "timeout": """
do clean() with:
    timeout(1s)
""",
    "timeout of parallel": """
do parallel:
    clean()
    clean()
    nap(3s)
with:
    timeout(1s)
""",
    "repeat": """
do serial:
    nap(1s)
    log("again")
with:
    repeat(3)
""",
    "repeat without end": """
do nap(0.5s) with:
    until elapsed(2.2s)
    repeat()
""",
    "retry": """
do broken() with:
    retry(3)
""",
    "inverter": """
do serial:
    broken() with:
        inverter()
    nap(1s)
""",
    "running_is_success": """
do serial:
    clean() with:
        running_is_success()
    clean() with:
        inverter()
        running_is_failure()
""",
    "success_is_running": """
do nap(1s) with:
    timeout(3s)
    success_is_running()
""",
    "a modifier with reactions": """
do nap(2s) with:
    patience()
    repeat(2)
""",
    "modifiers in a row": """
do serial:
    broken() with:
        timeout(9s)
        repeat(2)
        failure_is_success()
    nap(1s)
with:
    timeout(9s)
""",
    "override on start": """
do parallel:
    a: clean()
    serial:
        wait elapsed(1s)
        b: nap(1s)
with:
    override(a, b)
""",
    "override when active": """
do parallel:
    a: nap(2s)
    serial:
        wait elapsed(1s)
        b: nap(1s)
        log("out")
with:
    override(b, a, when_active)
""",
    "overrides of each other": """
do parallel:
    a: clean()
    b: clean()
with:
    override(a, b)
    override(b, a)
    timeout(3s)
""",
    "duration": """
do nap(2s) with:
    keep(it.duration in [1s..3s])
""",
    "a duration that is exceeded": """
do serial:
    clean()
with:
    keep(it.duration == 1s)
""",
    "an action with clean-up": """
do clean()
""",
    "actions with clean-up in a row": """
do parallel:
    clean()
    clean()
    serial:
        nap(1s)
        clean()
with:
    timeout(2s)
""",
    "an action that waits for the outside world": """
do parallel:
    ask()
    ask()
    nap(1s)
""",
    "an action that holds": """
do parallel(overlap: start):
    nap(1s)
    hold()
""",
    "background resources": """
do serial:
    keep_open()
    keep_open()
    nap(1s)
""",
    "exclusive uses": """
r: robot
do serial:
    r.move()
    parallel:
        r.move() with:
            timeout(0.5s)
            inverter()
        nap(1s)
    r.move()
""",
    "a stuck run": """
event never
do parallel:
    clean()
    wait @never
with:
    until elapsed(1s)
""",
    "an expression without a value": """
var n: int = 0
do parallel:
    clean()
    serial:
        wait elapsed(1s)
        log(1 / n)
""",
    "coverage": """
event go
var n: int = 0
cover(n, event: go)
do serial:
    emit go
    increment(n)
    wait elapsed(1s)
    emit go
""",
}


def text_of(name: str) -> str:
    """Return the text of a scenario."""
    body = "".join(f"    {line}\n" for line in BODIES[name].strip().splitlines())
    return f"{INVOKED}scenario main:\n{body}"
