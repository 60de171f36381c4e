"""Audit logs: every change is detected."""

import json
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from seoro.bridges.wire.lab import EMERGENCY_STOP, EmergencyStop
from seoro.bridges.wire.message import encode
from seoro.errors import UsageError
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.network.audit_trail import MOST_NAMES, AuditedRequest, AuditTrail
from seoro.security.signing.audit_log import AuditLog, check_log
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
    audit = AuditLog(path, keys)
    for number in range(count):
        audit.write(what="submit", by="anna", outcome="done", run=f"{number:032x}")
    audit.close()


def test_a_log_of_several_starts_is_valid(log: Path, keys: Keys) -> None:
    write(log, keys, 2)
    checked = check_log(log, keys.authority)
    assert (checked.count, checked.writers) == (7, (NAME,))
    assert log.stat().st_mode & 0o777 == 0o600


def test_an_incomplete_last_line_is_removed_and_the_log_continues(log: Path, keys: Keys) -> None:
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
def test_changes_to_a_log_are_detected(log: Path, keys: Keys, forge: Callable[[list[bytes]], list[bytes]]) -> None:
    log.write_bytes(b"".join(forge(log.read_bytes().splitlines(keepends=True))))
    with pytest.raises(UsageError, match=r"audit\.jsonl:\d: "):
        check_log(log, keys.authority)


def test_a_log_of_another_lab_is_invalid(log: Path, tmp_path: Path) -> None:
    other = make_lab(tmp_path / "other")
    with pytest.raises(UsageError, match="not signed by the lab"):
        check_log(log, read_keys(other.keys("ada")).authority)


def test_a_log_signed_by_another_role_is_invalid(lab: KeyedLab, tmp_path: Path) -> None:
    path = tmp_path / "audit.jsonl"
    write(path, read_keys(lab.keys("anna")), 1)
    with pytest.raises(UsageError, match="expected an executor or a node"):
        check_log(path, read_keys(lab.keys("vera")).authority)


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Path]:
    """Yield a folder on a disk of 1 MiB."""
    folder = tmp_path / "small"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", str(folder)]
    mounted = subprocess.run(command, check=False, capture_output=True, text=True)
    if mounted.returncode != 0:
        pytest.skip(f"nothing can be mounted here: {mounted.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def test_a_full_disk_has_room_for_emergency_stops(small: Path, keys: Keys) -> None:
    log = small / "audit.jsonl"
    audit = AuditLog(log, keys)
    with (small / "much").open("wb", buffering=0) as much, pytest.raises(OSError, match="No space left"):
        while True:
            much.write(bytes(4096))
    with pytest.raises(OSError, match="No space left"):
        while True:  # space for the next lines
            audit.write(what="submit", by="anna")
    for number in range(100):
        audit.write(is_urgent=True, what="emergency_stop", by="anna", outcome="done", reason=f"smoke {number}")
    (small / "much").unlink()
    audit.write(what="submit", by="anna")
    audit.close()
    assert check_log(log, keys.authority).writers == (keys.identity.name,)
    assert log.read_bytes().count(b'"emergency_stop"') == 100


@pytest.mark.parametrize("count", [0, 2, MOST_NAMES + 1])
def test_a_line_lists_the_robots_of_an_emergency_stop(keys: Keys, tmp_path: Path, count: int) -> None:
    path = tmp_path / "audit.jsonl"
    names = [f"tb{number}" for number in range(count)]
    audit = AuditLog(path, keys)
    stop = EmergencyStop(by="ana", robots=tuple(names))
    AuditTrail(audit).record_outcome(
        AuditedRequest(keys.identity, EMERGENCY_STOP.name, encode(stop)), None, "done"
    )
    audit.close()
    *_, line = map(json.loads, path.read_text().splitlines())
    assert (line["what"], line["by"]) == ("emergency_stop", NAME)
    more = ["and 1 more"] if count > MOST_NAMES else []
    assert line.get("robots", []) == names[:MOST_NAMES] + more
