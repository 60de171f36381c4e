"""The tree of a run: its rows, and its height."""

from itertools import count
from typing import Any

from seoro.cli.tree import ENDED_KEPT, MESSAGES_KEPT, UNFOLDED, Tree


class Run:
    """Gives a tree records, as a run would."""

    def __init__(self) -> None:
        self.tree = Tree()
        self._ids = count()
        self.time = 0.0

    def start(self, name: str, parent: int | None = None, type_: str = "serial") -> int:
        number = next(self._ids)
        self._record("behavior.start", id=number, parent=parent, type=type_, name=name, source="a.osc:1:1")
        return number

    def end(self, number: int, status: str = "succeeded", reason: str = "") -> None:
        self._record("behavior.end", id=number, status=status, reason=reason)

    def log(self, message: str) -> None:
        self._record("log", level="info", message=message, source="")

    def set(self, path: str, value: object) -> None:
        self._record("variable", path=path, value=value)

    def _record(self, kind: str, **fields: Any) -> None:
        self.tree.record({"t": self.time, "kind": kind, **fields})

    def names(self, height: int = 100) -> list[tuple[int, str]]:
        return [(row.depth, row.node.name if row.node else f"+{row.folded}") for row in self.tree.rows(height)]


def test_running_behaviors_are_below_their_parents() -> None:
    run = Run()
    main = run.start("main")
    run.start("a", main)
    second = run.start("b", main)
    run.start("c", second)
    assert run.names() == [(0, "main"), (1, "a"), (1, "b"), (2, "c")]


def test_ended_behaviors_keep_their_status_and_times() -> None:
    run = Run()
    main = run.start("main")
    part = run.start("part", main)
    run.time = 2.0
    run.end(part, "failed", "why")
    node = run.tree.rows(10)[1].node
    assert node is not None
    assert (node.start, node.end, node.status, node.reason) == (0.0, 2.0, "failed", "why")


def test_ended_behaviors_are_dropped_first() -> None:
    run = Run()
    main = run.start("main")
    for number in range(8):
        part = run.start(f"part {number}", main)
        run.end(run.start("inside", part))
        run.end(part)
    run.start("now", main)
    assert len(run.names(100)) == 18
    assert run.names(10) == [(0, "main"), *[(1, f"part {number}") for number in range(8)], (1, "now")]
    assert run.names(5) == [(0, "main"), (1, "part 5"), (1, "part 6"), (1, "part 7"), (1, "now")]
    assert run.names(2) == [(0, "main"), (1, "now")]
    assert run.tree.rows(2)[0].folded == 8


def test_failed_children_of_failed_behaviors_are_kept_longest() -> None:
    run = Run()
    main = run.start("main")
    for number in range(20):
        run.end(run.start(f"fine {number}", main))
    run.end(run.start("guilty", main), "failed", "why")
    run.end(main, "failed", "why")
    assert run.names(5) == [(0, "main"), (1, "guilty")]


def test_composite_behaviors_are_dropped_next() -> None:
    run = Run()
    inner = run.start("main")
    for number in range(10):
        inner = run.start(f"around {number}", inner)
    run.start("leaf", inner, "wait")
    assert run.names(5) == [(0, "main"), (1, "leaf")]


def test_of_too_many_that_run_the_others_are_counted() -> None:
    run = Run()
    main = run.start("main")
    for number in range(100):
        run.start(f"{number}", main, "wait")
    assert run.names(4) == [(0, "main"), (1, "0"), (1, "1"), (1, "+98")]
    assert all(len(run.tree.rows(height)) <= height for height in range(2, 120))


def test_memory_is_bounded() -> None:
    run = Run()
    main = run.start("main")
    for number in range(10 * UNFOLDED):
        part = run.start("part", main)
        run.end(run.start("inside", part))
        run.end(part)
        run.log(str(number))
        run.set(f"variable {number}", number)
    [root] = run.tree.roots
    assert len(root.children) <= 2 * ENDED_KEPT + 1
    assert root.folded + len(root.children) == 10 * UNFOLDED
    assert len(run.tree.messages) == MESSAGES_KEPT
    assert list(run.tree.variables.values())[-1] == 10 * UNFOLDED - 1
    assert len(run.tree.variables) < 100


def test_rows_of_an_empty_tree() -> None:
    assert Tree().rows(5) == []
