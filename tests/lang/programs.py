"""Valid programs that use most of what is supported, for tests that change them."""

from __future__ import annotations

PROGRAMS = (
    """import osc.types

enum colour: [red, green = 4, blue]
struct part:
    size: length = 2m
    count: int = 3
    shade: colour = green
    names: list of string = ["a", "b"]
    def area(scale: float = 2.0) -> length is expression size * scale + 1m
struct red_part inherits part(shade == red):
    heat: float = 1.5
actor machine:
    first: part = part(size: 3m, count: 1)
    limit: speed = 30kph - 2mps
action machine.work:
    target: length
    patience: time = 20s + 500ms
scenario task:
    worker: machine
    distance: length = (12m + 30cm) / 2
    event done(amount: length)
    do serial:
        wait elapsed(1s + 200ms)
        move: worker.work(target: distance + 2m, patience: 3min)
        parallel:
            worker.work(worker.first.area(2.0))
            one_of:
                wait @move.end
                wait elapsed(500ms)
        emit done(distance * 2.0)
scenario main:
    do serial:
        task()
""",
    """namespace plant use stdtypes
export *
type torque is SI(kg: 1, m: 2, s: -2)
unit Nm of torque is SI(kg: 1, m: 2, s: -2)
global top: torque = 5Nm
struct arm:
    pull: list of torque = [1Nm, 2Nm]
    def strongest() -> torque is expression pull.filter(it > 1Nm)[0]
    def sum(a: int, b: int) -> int is undefined
extend arm:
    spare: range of float = [1..2.5]
extend int:
    def twice() -> int is expression it * 2
namespace null use plant
scenario main:
    a: arm
    n: int = 3
    ok: bool = a.pull.size() == 2 and 1.5 in a.spare => not (n > 2 ? true : false)
    do serial:
        wait elapsed(1ms)
        emit end
""",
    """import osc.helpers
scenario greet:
    name: string
    times: int = 2
    event done(count: int, note: string = "n")
    do serial:
        log(name)
        emit done(times)
scenario main:
    event go
    do parallel:
        a: greet("bob")
        serial:
            wait @a.end
            emit go
        wait @go
""",
)
