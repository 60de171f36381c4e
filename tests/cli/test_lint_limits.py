"""Warnings of time limits that cannot be met, and of conditions that never change."""

from pathlib import Path

import pytest

from tests.cli.test_lints import BASE, codes_of

MET = ["""\
    do serial(duration: [1s..4s]):
        wait elapsed(3s)
        log('x')
""", """\
    do serial:
        wait elapsed(1s)
        log('x')
    with:
        repeat(3)
        timeout(2s)
""", """\
    do serial:
        serial:
            wait elapsed(3s)
        with:
            running_is_success()
        log('x')
    with:
        timeout(2s)
""", """\
    timeout(2s)
    do serial:
        wait elapsed([1s..3s])
        log('x')
""", """\
    x: int = 3
    do serial:
        wait x > 2 or x < 1
        wait elapsed(1s)
        log('x')
"""]  # fmt: skip
SUSPICIOUS = [("E0707", 5, """\
    timeout(2s)
    do serial:
        wait elapsed(3s)
        log('x')
"""), ("E0707", 5, """\
    do serial(duration: 2s):
        wait elapsed(3s)
        log('x')
"""), ("E0707", 9, """\
    do serial:
        wait elapsed([3s..4s])
        log('x')
    with:
        keep(it.duration < 2s)
"""), ("E0707", 9, """\
    do parallel:
        wait elapsed(3s)
        log('x')
    with:
        timeout(2s)
"""), ("E0707", 12, """\
    do serial:
        serial:
            wait elapsed(1s)
        with:
            repeat(3)
        log('x')
    with:
        timeout(2s)
"""), ("E0706", 7, """\
    x: int = 3
    do serial:
        wait x == x
        wait elapsed(1s)
        log('x')
"""), ("E0706", 7, """\
    x: int = 3
    do serial:
        wait x > 2 or 1 < 2
        wait elapsed(1s)
        log('x')
""")]  # fmt: skip


@pytest.mark.parametrize(("code", "line", "body"), SUSPICIOUS)
def test_limits_and_conditions_are_suspicious(
    code: str, line: int, body: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert codes_of(BASE + body, tmp_path, capsys) == [(line, code)]


@pytest.mark.parametrize("body", MET)
def test_limits_that_can_be_met_are_not_suspicious(
    body: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert codes_of(BASE + body, tmp_path, capsys) == []
