"""Permissions of scenarios at executors, and the spans of their diagnostics."""

from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest

import seoro
from seoro.embed import check_file
from seoro.embed.options import Options
from seoro.errors import ActionFailed, InvalidScenario, UsageError
from seoro.executor.permissions import (
    check_permissions,
    keeping_to,
    reader_of,
    vet_endpoints,
    vet_plan,
    vet_sources,
)
from seoro.files.path_mapping import unchanged_path
from seoro.lang.frontend import lower

EXTERNAL = """import osc.helpers
struct clock:
    def now() -> float is external time.time()
scenario main:
    do serial:
        log("x")
"""
PROGRAM = """import osc.helpers
scenario main:
    do parallel:
        log("x")
        serial:
            run_process("touch /tmp/never")
"""


def write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def vet(file: Path, *allowed: str) -> seoro.Scenario:
    return check_file(file, vet=partial(vet_sources, allowed=allowed))


def test_python_of_a_bundle_is_refused_before_its_import(tmp_path: Path) -> None:
    mark = tmp_path / "imported"
    write(tmp_path / "seoro.libraries/mine.osc", "action greet\n")
    write(tmp_path / "seoro.libraries/mine.py", f"open({str(mark)!r}, 'w')\n")
    file = write(tmp_path / "main.osc", "import osc.mine\nscenario main:\n    do greet()\n")
    with pytest.raises(InvalidScenario) as caught:
        vet(file)
    [found] = caught.value.diagnostics
    assert found.primary.span.line == 1
    assert "--allow python" in found.help
    assert not mark.exists()


def test_external_methods_are_refused_with_their_position(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario) as caught:
        vet(write(tmp_path / "main.osc", EXTERNAL))
    [found] = caught.value.diagnostics
    assert found.primary.span.line == 3


def test_external_methods_of_imported_files_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "other.osc", EXTERNAL)
    with pytest.raises(InvalidScenario):
        vet(write(tmp_path / "main.osc", 'import "other.osc"\n'))


def test_allowed_external_methods_pass(tmp_path: Path) -> None:
    scenario = vet(write(tmp_path / "main.osc", EXTERNAL), "python")
    assert not scenario.checked.errors


def test_programs_are_refused_with_their_position(tmp_path: Path) -> None:
    scenario = vet(write(tmp_path / "main.osc", PROGRAM))
    plan = lower(scenario.checked, None, {})
    with pytest.raises(InvalidScenario) as caught:
        vet_plan(plan, ())
    [found] = caught.value.diagnostics
    assert found.primary.span.line == 6
    assert "--allow run_process" in found.help
    vet_plan(plan, ("run_process",))


def test_files_of_the_executor_are_not_disclosed_by_imports(tmp_path: Path) -> None:
    secret = write(tmp_path / "secret.txt", "my password\n")
    file = write(tmp_path / "bundle/main.osc", f'import "{secret}"\nimport "../secret.txt"\n')
    scenario = check_file(file, read=reader_of(tmp_path / "bundle"))
    text = str(InvalidScenario(scenario.checked.errors))
    assert "the file was not sent" in text
    assert "password" not in text


def test_unknown_permissions_are_refused() -> None:
    with pytest.raises(UsageError, match="everything"):
        check_permissions({"everything"})


@pytest.mark.parametrize(
    "options",
    [
        seoro.Simulator(endpoint="tcp/192.168.0.7:7450"),
        seoro.Ros("tcp/192.168.0.7:7450"),
        "bridges:\n  floor: {connect: tcp/192.168.0.7:7450}\nrobots:\n  leader: {in: floor}\n",
    ],
)
def test_endpoints_on_other_machines_need_a_permission(
    options: seoro.Simulator | seoro.Ros | str, tmp_path: Path
) -> None:
    match options:
        case seoro.Simulator():
            wanted = Options(simulator=options)
        case seoro.Ros():
            wanted = Options(ros=options)
        case text:
            wanted = Options(lab=seoro.Lab(write(tmp_path / "lab.yaml", text)))
    with pytest.raises(
        UsageError, match=r"does not allow scenarios to connect to tcp/192\.168\.0\.7:7450"
    ) as caught:
        vet_endpoints(wanted, ["python"], ["tcp/192.168.0.8:7450"])
    assert "--allow network" in (caught.value.help or "")
    vet_endpoints(wanted, ["network"], ())
    vet_endpoints(wanted, (), ["tcp/192.168.0.7:7450"])


def test_local_endpoints_need_no_permission() -> None:
    local = ["tcp/127.0.0.1:7450", "unixsock-stream//tmp/hub", "tcp/[::1]:7450"]
    allowed = []
    for endpoint in (*local, "tcp/192.168.0.7:7450"):
        with suppress(UsageError):
            vet_endpoints(Options(simulator=seoro.Simulator(endpoint=endpoint)), (), ())
            allowed.append(endpoint)
    assert allowed == local


def test_only_bundled_and_output_files_are_readable(tmp_path: Path) -> None:
    sent, left, other = tmp_path / "files", tmp_path / "output", tmp_path / "other.yaml"
    for folder in (sent, left):
        folder.mkdir()
    other.touch()
    (sent / "link").symlink_to(other)
    kept = keeping_to((sent, left), unchanged_path, ())
    assert kept(sent / "bag") == sent / "bag"
    assert kept(left / "bag") == left / "bag"
    for path in (other, sent / ".." / "other.yaml", sent / "link", Path("/etc/passwd")):
        with pytest.raises(
            ActionFailed, match=f"does not allow scenarios to read {path}, which was not sent.*--allow files"
        ):
            kept(path)
    assert keeping_to((sent,), unchanged_path, ("files",))(other) == other
