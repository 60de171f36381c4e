"""Text of others: it controls no terminal, and forges no line of a table or a log."""

import io
import logging
from argparse import Namespace
from pathlib import Path

import pytest

from seoro.bridges.executor.messages import RunInfo, State
from seoro.cli import doctor_command, get_command
from seoro.cli.lab_command import _print_outcomes
from seoro.cli.ps_command import _row
from seoro.cli.tables import table
from seoro.client.runs import RemoteRun
from seoro.doctor.findings import Finding, Health
from seoro.lab.outcomes import Outcome
from seoro.text.logs import PrintableFormatter
from seoro.text.printable import one_line, printable


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a\n\nFAKE  bg  passed", "a FAKE bg passed"),
        ("smoke\x1b[2J\r\nok", "smoke\ufffd[2J\ufffd ok"),
        ("grüße", "grüße"),
    ],
)
def test_a_text_fits_into_a_line(text: str, line: str) -> None:
    assert one_line(text) == line


def test_lines_of_longer_texts_stay() -> None:
    assert printable("a\n\tb\x07") == "a\n\tb\ufffd"


def test_a_record_of_a_log_is_one_line_with_its_traceback() -> None:
    written = io.StringIO()
    handler = logging.StreamHandler(written)
    handler.setFormatter(PrintableFormatter("%(levelname)s: %(message)s"))
    log = logging.Logger("test")
    log.addHandler(handler)
    log.warning("released by %s", "bob\x1b[2J\nok  the node x: stopped")
    try:
        raise ValueError("x\x1b[2J")
    except ValueError:
        log.exception("fault")
    first, *rest = written.getvalue().splitlines()
    assert first == "WARNING: released by bob\ufffd[2J ok the node x: stopped"
    assert rest[0] == "ERROR: fault"
    assert rest[-1] == "ValueError: x\ufffd[2J"


def test_fields_of_runs_cannot_forge_lines() -> None:
    info = RunInfo(
        run="a" * 32,
        file="x.osc\nFAKE  lab-a  passed",
        by="eve\nFAKE",
        state=State.QUEUED,
        submitted=0.0,
        waits="\nFAKE",
    )

    class _Named:
        name = "lab-a"

    assert "\n" not in table([_row(RemoteRun(_Named(), info), 1.0)])  # type: ignore[arg-type]


FORGED = "hall\n\x1b[2Jok      the node x: stopped"
LINE = "hall \ufffd[2Jok the node x: stopped"


def test_names_of_nodes_cannot_forge_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names of nodes come from the network, too."""
    outcomes = [Outcome("tcp/x", FORGED, error=FORGED), Outcome("tcp/x", FORGED, done=FORGED)]
    assert _print_outcomes(Namespace(json=False), outcomes) == 3
    assert capsys.readouterr().out == f"FAILED {LINE}: {LINE}\nok     {LINE}: {LINE}\n"

    async def nothing(*_: object) -> None:
        return None

    finding = Finding(FORGED, Health.FAILED, FORGED, FORGED)
    monkeypatch.setattr(doctor_command, "check_installation", lambda: [finding])
    monkeypatch.setattr(doctor_command, "_check_network", nothing)
    assert doctor_command.run(Namespace(json=False)) == 1
    shown = capsys.readouterr().out.splitlines()
    assert shown[:2] == [f"{'failed':8} {LINE}: {LINE}", f"{'':8} = help: {LINE}"]
    assert len(shown) == 3


async def test_names_of_output_files_cannot_forge_paths(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    async def left(_: Namespace) -> list[Path]:
        return [Path("out", FORGED)]

    monkeypatch.setattr(get_command, "_get", left)
    await get_command.run(Namespace())
    assert capsys.readouterr().out == f"out/{LINE}\n"
