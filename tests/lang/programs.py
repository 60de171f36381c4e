"""Valid programs with most supported constructs, for tests that change them."""

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
    """import osc.types
enum load: [empty, half, full]
struct crate:
    fill: load
    weight: int
    width: length with:
        keep(it in [1m..3m])
        cover(wide, expression: it, unit: cm, range: [0..300], every: 50)
    is_new: bool = true
    keep(default weight == 3)
    keep(fill == empty => weight in [0..2])
    keep(weight < 10 and weight >= 0)
struct full_crate inherits crate(fill == full):
    seal: string = "red"
    keep(weight > 5)
actor crane:
    reach: length = 4m
    held: crate
    var turns: int = 0
    def double(n: int) -> int is expression 2 * n
action crane.lift:
    what: crate
    height: length
    keep(height in [0m..reach_limit])
    reach_limit: length = 5m
scenario crane.shift:
    what: crate
    event halfway(at: length)
    do serial:
        up: lift(what, height: 1m)
        emit halfway(2m)
        lift(what: what) with:
            keep(it.height == 2m)
modifier gently of crane.lift:
    pace: speed = 1mps
    keep(it.height < 3m)
    on @it.start:
        emit slow
    event slow
modifier limit of main:
    most: int
    keep(it.tries < most)
scenario main:
    tries: int = 2
    c: crane
    sizes: list of int
    keep(sizes.size() == 3)
    keep(sizes[0] == 4)
    keep(not sizes.has(it < 0))
    keep(not sizes.has(it > 9))
    limits: range of float
    keep(1.5 in limits)
    keep(limits.lower() > 0.0 and limits.upper() < 4.0)
    remove_default(c.held.weight)
    event going
    event moved is @going if c.held.weight > 2
    event soon is elapsed(2s)
    event again is every(1s, offset: 500ms)
    var count: int = sample(count + 1, @moved)
    var last: length = 3m
    cover(last, unit: m, range: [0..10], every: 2, event: moved)
    cover(many, expression: count, event: moved)
    record(count, event: end)
    cover(both, items: [last, many], event: moved)
    limit(3)
    on @moved as m if count < 3:
        emit going
        call c.double(count)
    do parallel(overlap: initial, start_to_start: [0s..1s], duration: 5s):
        first: serial:
            wait @going
            c.shift(c.held) with:
                until @again
        second: one_of(duration: [1s..9s]):
            c.lift(c.held, height: 1m) with:
                gently(pace: 1mps)
                until rise(count > 2)
            wait fall(last > 2m)
        with:
            override(first, second)
        third: serial:
            emit going
            call c.double(3)
            wait c.held.fill == full
""",
)
