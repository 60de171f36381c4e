"""Renames to conflicting names: refused with the position of the other name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from seoro.lsp import navigation
from seoro.lsp.analysis import analyse, analyse_users
from seoro.lsp.rename_check import check_collisions
from tests.lsp.helpers import SCENARIO, split

FAMILY = """struct base:
    event e
    def weight() -> int is expression 1
struct derived inherits base:
    def weight() -> int is only expression 2
    def mass() -> int is expression 3
    count: int = 1
scenario main:
    x: derived
    n: int = x.weight()
    do serial:
        first: serial:
            wait elapsed(x.count * 1s)
        second: serial:
            wait @first.end
"""
TIME = "import osc.types\n"


def rename(folder: Path, marked: str, new: str, others: Mapping[str, str] | None = None) -> int:
    """Rename the symbol at the mark; return the number of changed places."""
    text, offset = split(marked)
    for name, content in (others or {}).items():
        (folder / name).write_text(content, encoding="utf-8")
    path = folder / "test.osc"
    path.write_text(text, encoding="utf-8")
    found = analyse(path, {})
    _, span, target = navigation.check_rename(found, offset)
    users = analyse_users((span.text, new), [folder], {}, [found])
    edits = navigation.edits(target, span.text, new, users)
    check_collisions(edits, new, users, {})
    return sum(map(len, edits.values()))


def at(text: str, place: str) -> str:
    """Return a text with a mark at the first match."""
    return text.replace(place.replace("|", ""), place, 1)


@pytest.mark.parametrize(
    ("text", "place", "new"),
    [
        (SCENARIO, "struct b|ox", "crane"),  # a type
        (SCENARIO, "struct b|ox", "color"),
        (SCENARIO, "action crane.l|ift", "lift2"),
        (SCENARIO, "    cr|ate: box", "limit"),  # a member
        (SCENARIO, "event g|o", "crate"),
        (SCENARIO, "[r|ed, green]", "green"),  # a member of an enumeration
        (SCENARIO, "what|: box", "height"),  # a parameter of an action
        (SCENARIO, "times(co|unt", "of"),  # a parameter of a method
        (SCENARIO, "event go(c|ount", "count2"),
        (TIME + FAMILY, "se|cond:", "first"),  # a label
        (TIME + FAMILY, "def m|ass", "count"),
        (TIME + FAMILY, "def m|ass", "e"),  # a member of a base
        (TIME + FAMILY, "def w|eight", "load2"),  # with an overriding method
        (TIME + FAMILY, "x: derived\n    n|: int", "x"),
    ],
)
def test_a_name_that_is_in_use_is_refused(tmp_path: Path, text: str, place: str, new: str) -> None:
    if new.endswith("2"):
        assert rename(tmp_path, at(text, place), new) > 1  # free
        return
    with pytest.raises(navigation.CannotRename, match=f"`{new}` (is in use|changes)"):
        rename(tmp_path, at(text, place), new)


def test_a_name_of_another_action_of_the_actor_is_refused(tmp_path: Path) -> None:
    text = "actor bot\naction bot.tr|ip\naction bot.go\nscenario main:\n    b: bot\n    do b.trip()\n"
    with pytest.raises(navigation.CannotRename, match=r"`go` is in use: duplicate action .*test.osc:3"):
        rename(tmp_path, text, "go")


def test_a_name_in_a_file_that_imports_this_one_is_in_use(tmp_path: Path) -> None:
    other = 'import "test.osc"\nstruct crate\n'
    with pytest.raises(navigation.CannotRename, match=r"other\.osc:2"):
        rename(tmp_path, "struct b|ox\n", "crate", {"other.osc": other})


def test_a_rename_that_changes_the_meaning_of_a_use_is_refused(tmp_path: Path) -> None:
    text = "global limi|t: int = 1\nscenario main:\n    bound: int = 2\n    n: int = limit\n"
    with pytest.raises(navigation.CannotRename, match="would change its meaning"):
        rename(tmp_path, text, "bound")


def test_existing_errors_do_not_prevent_a_rename(tmp_path: Path) -> None:
    text = "struct b|ox\nstruct other:\n    a: nothing\n    b: box\n"
    assert rename(tmp_path, text, "crate") == 2


ROUTES = """import osc.types
struct base:
    event moved(by: length)
    def gain(factor: int) -> int is expression factor
struct middle inherits base:
    event moved(by: length = 1m)
struct derived inherits middle:
    def gain(factor: int) -> int is only expression factor + 1
    def bonus() -> int is expression 5
struct unrelated:
    event moved
    def gain(factor: int) -> int is expression 1
scenario main:
    a: base
    b: derived
    n: int = a.gain(factor: 1) + b.gain(factor: 2)
    do serial:
        wait @a.moved
        wait @b.moved
"""


@pytest.mark.parametrize(
    ("place", "count"),
    [
        ("    event mo|ved(by: length)", 4),
        ("    event mo|ved(by: length = 1m)", 4),
        ("wait @b.mo|ved", 4),
        ("event moved(b|y: length)", 2),
        ("def ga|in(factor: int) -> int is expression factor", 4),
        ("def ga|in(factor: int) -> int is only", 4),
        ("b.ga|in(", 4),
        ("def gain(fac|tor: int) -> int is only", 6),
        ("event mo|ved\n", 1),
    ],
)
def test_members_that_override_each_other_are_renamed_together(tmp_path: Path, place: str, count: int) -> None:
    assert rename(tmp_path, at(ROUTES, place), "other") == count


def test_a_name_in_use_by_one_overriding_type_is_refused(tmp_path: Path) -> None:
    text = at(ROUTES, "def ga|in(factor: int) -> int is expression factor")
    with pytest.raises(navigation.CannotRename, match="`bonus` is in use"):
        rename(tmp_path, text, "bonus")


def test_overriding_members_of_other_files_are_renamed(tmp_path: Path) -> None:
    other = 'import "test.osc"\nstruct derived inherits base:\n    def gain() -> int is only expression 2\n'
    text = "struct base:\n    def ga|in() -> int is expression 1\n"
    assert rename(tmp_path, text, "load", {"other.osc": other}) == 2
