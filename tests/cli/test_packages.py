"""Commands name the extra whose packages they miss."""

import pytest

from seoro.cli import packages
from seoro.cli.main import main


@pytest.mark.parametrize(
    ("arguments", "package", "extra"),
    [
        (["lsp"], "pygls", "lsp"),
        (["mcp"], "mcp", "mcp"),
        (["ui"], "starlette", "ui"),
        (["bag", "x.mcap"], "mcap", "ros2"),
        (["ros", "topic", "list"], "mcap", "ros2"),
        (["bridge", "ros2", "--expose"], "mcap", "ros2"),
    ],
)
def test_commands_name_the_extra_of_a_missing_package(
    arguments: list[str],
    package: str,
    extra: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(packages, "find_spec", lambda _: None)
    assert main(arguments) == 2
    message = (
        f"error: `seoro {arguments[0]}` needs the package {package}\n  = help: pip install 'seoro[{extra}]'\n"
    )
    assert capsys.readouterr().err == message
