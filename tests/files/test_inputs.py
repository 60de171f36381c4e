"""Files that users name: regular ones within limits are read, by one module, and everything else is refused."""

from __future__ import annotations

import ast
import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from seoro.files.inputs import Kind, UnsuitableFile, open_input, read_input, read_input_text, resolved

ROOT = Path(__file__).parents[2]

# Files that seoro itself writes or brings along, and that no user names.
OWN = {
    "seoro/cli/new_command.py": "its own templates",
    "seoro/files/schemas/__init__.py": "schemas that come with seoro",
    "seoro/bridges/leasing/emergency_stop.py": "its own file of an emergency stop",
    "seoro/bridges/ros2/interfaces/packages.py": "definitions that come with seoro",
    "seoro/bridges/ros2/recording/scanning.py": "a copy that it mends",
    "seoro/bridges/ros2/robots/profile.py": "profiles that come with seoro",
    "seoro/security/network/authorizer.py": "a lock",
    "seoro/bundle/unpack.py": "blobs of the executor",
    "seoro/files/cache.py": "its own cache",
    "seoro/campaign/dask/tasks.py": "files of its own runs",
    "seoro/campaign/store/lines.py": "rows that it writes",
    "seoro/campaign/work/running.py": "/proc",
    "sim_nodes/models/decomposition.py": "arrays between its own processes",
    "seoro/ui/application.py": "pages that come with seoro",
    "seoro/cli/follower.py": "files that it has just fetched",
    "seoro/embed/output_folder.py": "its own index",
    "seoro/cli/rewriting.py": "writes a new file",
    "seoro/executor/storage/blobs.py": "blobs of the executor",
    "seoro/executor/sandbox/broker.py": "certificates in the folder of the executor's keys",
    "seoro/executor/sandbox/enter.py": "/proc",
    "seoro/executor/runs/memory.py": "/proc",
    "seoro/executor/runs/queue.py": "traces that it writes",
    "seoro/executor/handlers.py": "files of runs, in folders of the executor",
    "seoro/executor/storage/store.py": "a lock",
    "seoro/executor/runs/records.py": "traces of runs, in folders of the executor",
    "seoro/campaign/work/processes.py": "/proc",
    "seoro/report/page.py": "pages that come with seoro",
    "seoro/traces/foxglove/recording.py": "a layout that comes with seoro",
    "seoro/executor/process/worker.py": "a log that it writes",
    "seoro/actions/supervisor.py": "/proc",
    "sim_nodes/memory.py": "/proc",
    "seoro/runtime/execution/blocking.py": "/proc",
    "seoro/security/signing/audit_log.py": "the log that it writes",
    "seoro/security/keys/files.py": "writes a new file",
    "seoro/lang/explain.py": "explanations that come with seoro",
    "seoro/lang/grammar.py": "the grammar",
    "seoro/lang/builtin_libraries.py": "libraries that come with seoro",
    "seoro/lang/parse_table.py": "the table of the grammar",
    "seoro/cli/results.py": "files that it writes",
    "sim_nodes/worlds/loader.py": "worlds that come with seoro",
}
WRITING = {"w", "wb", "x", "xb", "a", "ab", "r+b"}
PARSING = {"open", "parse", "load"}
MODULES = {"Image", "ElementTree", "np", "ET"}  # modules with functions that open files


def large(path: Path) -> None:
    path.touch()
    os.truncate(path, 5 << 20)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (os.mkfifo, "it is a pipe; expected a regular file"),
        (lambda path: path.symlink_to("/dev/zero"), "it is a device"),
        (lambda path: path.symlink_to("/dev/tty"), "it is a device|No such device"),
        (lambda path: path.mkdir(), "Is a directory"),
        (lambda path: path.symlink_to(path), "Too many levels of symbolic links"),
        (lambda path: socket.socket(socket.AF_UNIX).bind(str(path)), "it is a socket"),
        (
            large,
            "it is larger than 4 MiB, the limit for models",
        ),
        (lambda path: None, "No such file"),
    ],
)
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_irregular_files_are_rejected_at_once(tmp_path: Path, make: Callable[[Path], object], reason: str) -> None:
    path = tmp_path / "file"
    make(path)
    with pytest.raises(OSError, match=reason):
        read_input(path, Kind.MODEL)
    assert resolved(path).is_absolute()


def test_system_files_without_size_are_limited() -> None:
    assert os.stat("/proc/self/mountinfo").st_size == 0  # noqa: PTH116 - as it is for all of these
    assert read_input(Path("/proc/self/status"), Kind.SETTINGS)


def test_a_path_that_cannot_be_is_refused() -> None:
    with pytest.raises(UnsuitableFile, match="its path is invalid"):
        open_input(Path("a\0b"), Kind.MODEL)


def test_a_text_is_read_as_others_read_it(tmp_path: Path) -> None:
    (tmp_path / "text").write_bytes(b"\xef\xbb\xbfone\r\ntwo\rthree\n")
    assert read_input_text(tmp_path / "text", Kind.SETTINGS) == "one\ntwo\nthree\n"


def _opens(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the calls of a module that open files: line and name of the function."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        given = (*node.args, *(key.value for key in node.keywords))
        modes = {each.value for each in given if isinstance(each, ast.Constant)}
        match node.func:
            case ast.Name(id="open") if not modes & WRITING:
                yield node.lineno, "open"
            case ast.Attribute(value=ast.Name(id=owner), attr="open" | "parse" | "load" as name) if (
                owner in MODULES
            ):
                yield node.lineno, f"{owner}.{name}"
            case ast.Attribute(attr="read_text" | "read_bytes" as name):
                yield node.lineno, name
            case ast.Attribute(attr="open") if modes & {"r", "rb"}:
                yield node.lineno, "open"


def test_every_reader_of_files_that_users_name_uses_the_one_module() -> None:
    found = []
    for package in ("seoro", "sim_nodes"):
        for path in sorted((ROOT / package).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            if name in OWN:
                continue
            for line, call in _opens(ast.parse(path.read_text(encoding="utf-8"))):
                found.append(f"{name}:{line}: {call}")
    allowed = {  # files that `open_input` has opened before
        "sim_nodes/worlds/pictures.py": "Image.open",
        "sim_nodes/models/pictures.py": "Image.open",
        "seoro/bundle/worlds.py": "ElementTree.parse",
    }
    found = [each for each in found if not each.endswith(allowed.get(each.partition(":")[0], "nothing"))]
    assert found == [], "use `seoro.files.inputs`, or name the file in `OWN` with the reason"
