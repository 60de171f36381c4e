"""Findings about the installation, with suggestions."""

import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from seoro import __version__
from seoro.doctor import installation as installed
from seoro.doctor.findings import Health
from seoro.executor.sandbox import bubblewrap

PROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_installed_packages_are_reported_with_their_version() -> None:
    found = {finding.what: finding for finding in installed.check_installation()}
    assert __version__ in found["seoro"].text
    assert found["eclipse-zenoh"].text == metadata.version("eclipse-zenoh")
    assert found["eclipse-zenoh"].health is Health.OK


def test_missing_packages_are_reported_with_their_installation(monkeypatch: pytest.MonkeyPatch) -> None:
    def version(name: str) -> str:
        if name in ("mujoco", "msgpack", "mcp"):
            raise metadata.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(installed, "version", version)
    found = {finding.what: finding for finding in installed.check_installation()}
    assert "mcp (tools for agents)" in found["more extras"].text.partition("not installed")[2]
    assert found["more extras"].health is Health.OK
    assert (found["mujoco"].health, found["msgpack"].health) == (Health.WARNING, Health.FAILED)
    assert "pip install 'seoro[mujoco]'" in found["mujoco"].help


def test_all_extras_for_users_are_checked() -> None:
    parts = {"node", "docs", "dev"}  # of other extras, and for the development of seoro
    declared = set(tomllib.loads(PROJECT.read_text())["project"]["optional-dependencies"])
    assert {extra.name for extra in (*installed.EXTRAS, *installed.MORE_EXTRAS)} == declared - parts


@pytest.mark.parametrize(
    ("size", "text"), [(12, "12 B"), (2048, "2.0 KiB"), (5 << 30, "5.0 GiB"), (5 << 60, "5242880.0 TiB")]
)
def test_sizes_are_printed_with_a_fitting_unit(size: int, text: str) -> None:
    assert installed.in_bytes(size) == text


def test_a_missing_sandbox_is_reported_with_a_fix(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bubblewrap, "PROGRAM", "no-such-program")
    [found] = [finding for finding in installed.check_installation() if finding.what == "sandbox"]
    assert found.health is Health.WARNING
    assert "`no-such-program` is not installed: install bubblewrap" in found.text
    assert "the executor's account" in found.help


@pytest.mark.parametrize(
    ("program", "user", "words"),
    [
        ("no-such-program", 1000, "but not the number of processes (runs have no sandbox)"),
        ("true", 0, "but not the number of processes (it exempts root)"),
        ("true", 1000, "and the number of processes and threads of a run"),
    ],
)
def test_limits_of_the_kernel_are_reported(
    monkeypatch: pytest.MonkeyPatch, program: str, user: int, words: str
) -> None:
    monkeypatch.setattr(bubblewrap, "PROGRAM", program)
    monkeypatch.setattr("seoro.executor.sandbox.kernel_limits.os.geteuid", lambda: user)
    [found] = [finding for finding in installed.check_installation() if finding.what == "limits"]
    assert found.health is Health.OK
    assert words in found.text
