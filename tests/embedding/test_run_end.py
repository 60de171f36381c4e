"""The end of a run as bytes."""

from pathlib import Path

import pytest

import seoro
from seoro.embed.run_end import Ended, InvalidEnd, NotStarted, ResultFile, not_started, pack_end, unpack_end
from seoro.errors import BackendError, InvalidScenario, UsageError
from seoro.runtime.explain.reasons import reason_text

FAILING = """import osc.helpers
scenario failing:
    event go
    limit: time = 3s
    cover(limit, unit: s, range: [0..5], every: 1)
    do parallel:
        wait @go
        serial:
            wait elapsed(limit)
            log("so far")
            emit fail
"""


def verdict_of(text: str, folder: Path) -> seoro.Verdict:
    file = folder / "test.osc"
    file.write_text(text)
    return seoro.run(seoro.load(file), seed=1, clock="virtual")


def test_a_verdict_is_restored(tmp_path: Path) -> None:
    verdict = verdict_of(FAILING, tmp_path)
    left = (ResultFile("picture.png", "a picture"),)
    found = unpack_end(pack_end(Ended(verdict, {"limit": 3.0}, left, "", "")))
    assert isinstance(found, Ended)
    assert reason_text(found.verdict) == reason_text(verdict)
    assert "test.osc:" in reason_text(verdict)
    assert [item.plain() for item in found.verdict.coverage] == [item.plain() for item in verdict.coverage]
    assert found.verdict.explanation is not None
    assert verdict.explanation is not None
    assert found.verdict.explanation.plain() == verdict.explanation.plain()
    assert found.files == left


def test_diagnostics_are_restored(tmp_path: Path) -> None:
    file = tmp_path / "test.osc"
    file.write_text("scenario wrong:\n    do serial:\n        log(1m + 2s)\n")
    with pytest.raises(InvalidScenario) as caught:
        seoro.load(file)
    found = unpack_end(pack_end(not_started(caught.value)))
    assert isinstance(found, NotStarted)
    assert str(found.error) == str(caught.value)


def test_a_usage_error_is_restored() -> None:
    found = unpack_end(pack_end(not_started(UsageError("it cannot be", help="try another"))))
    assert isinstance(found, NotStarted)
    assert isinstance(found.error, UsageError)
    assert (str(found.error), found.error.help) == ("it cannot be", "try another")


def test_a_backend_error_is_restored() -> None:
    found = unpack_end(pack_end(not_started(BackendError("it is gone"))))
    assert isinstance(found, NotStarted)
    assert str(found.error) == "it is gone"


@pytest.mark.parametrize("data", [b"", b"\xc1", b"\x01", b"\x92\x90\x92\xc0\xc0", b"\x92\x90\x92\x01\xc0"])
def test_invalid_bytes_are_rejected(data: bytes) -> None:
    with pytest.raises(InvalidEnd):
        unpack_end(data)


def test_damaged_bytes_are_rejected(tmp_path: Path) -> None:
    data = pack_end(Ended(verdict_of(FAILING, tmp_path), {}, (), "", ""))
    refused = 0
    for at in range(0, len(data), 7):
        spoiled = data[:at] + bytes([data[at] ^ 0x15]) + data[at + 1 :]
        try:
            assert isinstance(unpack_end(spoiled), Ended | NotStarted)
        except InvalidEnd:
            refused += 1
    assert refused > 0
