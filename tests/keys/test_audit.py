"""Logs of what was asked: nothing in them can be changed unnoticed."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.errors import InvalidUse
from seoro.keys.audit import Audit, check_log
from seoro.keys.folder import Keys, read_keys
from tests.labs import NAME, KeyedLab, make_lab


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture
def keys(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys(NAME))


@pytest.fixture
def log(keys: Keys, tmp_path: Path) -> Path:
    path = tmp_path / "audit.jsonl"
    write(path, keys, 3)
    return path


def write(path: Path, keys: Keys, count: int) -> None:
    audit = Audit(path, keys)
    for number in range(count):
        audit.write(what="submit", by="anna", outcome="done", run=f"{number:032x}")
    audit.close()


def test_a_log_holds_over_several_starts(log: Path, keys: Keys) -> None:
    write(log, keys, 2)
    checked = check_log(log, keys.authority)
    assert (checked.count, checked.writers) == (7, (NAME,))
    assert log.stat().st_mode & 0o777 == 0o600


def test_what_was_half_written_is_gone_and_the_log_goes_on(log: Path, keys: Keys) -> None:
    with log.open("ab") as file:
        file.write(b'{"number": 4, "ti')
    write(log, keys, 1)
    assert check_log(log, keys.authority).count == 6


def change(lines: list[bytes]) -> list[bytes]:
    return [line.replace(b'"anna"', b'"vera"') if number == 2 else line for number, line in enumerate(lines)]


def take_out(lines: list[bytes]) -> list[bytes]:
    return lines[:2] + lines[3:]


def take_the_first(lines: list[bytes]) -> list[bytes]:
    return lines[1:]


def double(lines: list[bytes]) -> list[bytes]:
    return [*lines, lines[-1]]


def turn_round(lines: list[bytes]) -> list[bytes]:
    return [lines[0], lines[2], lines[1], lines[3]]


def put_in(lines: list[bytes]) -> list[bytes]:
    return [*lines, json.dumps({"number": 4, "what": "x", "signature": ""}).encode() + b"\n"]


@pytest.mark.parametrize("forge", [change, take_out, take_the_first, double, turn_round, put_in])
def test_what_was_done_to_a_log_is_noticed(
    log: Path, keys: Keys, forge: Callable[[list[bytes]], list[bytes]]
) -> None:
    log.write_bytes(b"".join(forge(log.read_bytes().splitlines(keepends=True))))
    with pytest.raises(InvalidUse, match=r"audit\.jsonl:\d: "):
        check_log(log, keys.authority)


def test_a_log_of_another_lab_does_not_hold(log: Path, tmp_path: Path) -> None:
    other = make_lab(tmp_path / "other")
    with pytest.raises(InvalidUse, match="not signed by the lab"):
        check_log(log, read_keys(other.keys("ada")).authority)


def test_only_executors_write_logs(lab: KeyedLab, tmp_path: Path) -> None:
    path = tmp_path / "audit.jsonl"
    write(path, read_keys(lab.keys("anna")), 1)
    with pytest.raises(InvalidUse, match="is neither an executor nor a node"):
        check_log(path, read_keys(lab.keys("vera")).authority)
