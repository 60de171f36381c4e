"""Imports (7.7.5)."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from seoro.lang import frontend
from seoro.lang.loader import path_of
from tests.installed_packages import add_entry_points


def write(folder: Path, **files: str) -> Path:
    """Write `main.osc` and other files; return the path of the first."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.osc"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder / "main.osc"


def order(path: Path) -> list[str]:
    return [module.file.path.stem for module in frontend.load(path).modules if module.file.path is not None]


def test_files_are_read_once_and_depth_first(tmp_path: Path) -> None:
    main = write(
        tmp_path,
        main='import "a.osc"\nimport "b.osc"\nimport "a.osc"\n',
        a='import "parts/c.osc"\n',
        b='import "parts/../a.osc"\n',
        parts__c='import "d.osc"\n',
        parts__d="struct x\n",
    )
    assert order(main) == ["d", "c", "a", "b", "main"]
    assert frontend.load(main).diagnostics == ()


def test_files_may_import_each_other(tmp_path: Path) -> None:
    main = write(tmp_path, main='import "a.osc"\nstruct y:\n    x: x\n', a='import "main.osc"\nstruct x\n')
    checked = frontend.check(frontend.load(main))
    assert checked.diagnostics == ()


def test_files_are_named_by_uri_or_path(tmp_path: Path) -> None:
    a = write(tmp_path, a="struct x\n").with_name("a.osc")
    for reference in (a.as_uri(), str(a), f"file:{a}"):
        main = write(tmp_path, main=f'import "{reference}"\n')
        assert order(main) == ["a", "main"]


def test_a_long_chain_of_imports_is_loaded_without_recursion(tmp_path: Path) -> None:
    for number in range(1200):
        (tmp_path / f"f{number}.osc").write_text(f'import "f{number + 1}.osc"\n', encoding="utf-8")
    (tmp_path / "f1200.osc").write_text("struct x\n", encoding="utf-8")
    assert len(frontend.load(tmp_path / "f0.osc").modules) == 1201


def test_libraries_are_listed_in_order(tmp_path: Path) -> None:
    sources = frontend.load(write(tmp_path, main="import osc.ros\nimport osc.gazebo\n"))
    assert tuple(library.name for library in sources.libraries) == (
        "osc.ros",
        "osc.types",
        "osc.robotics",
        "osc.nav2",
        "osc.gazebo",
    )


def test_a_missing_file_is_reported_without_raising(tmp_path: Path) -> None:
    (found,) = frontend.load(tmp_path / "none.osc", "none.osc").diagnostics
    assert found.code == "E0101"
    assert "No such file" in found.message


@pytest.mark.parametrize(
    ("data", "reason"), [(b"struct \xff", "not UTF-8"), (b"#" * (4 * 1024 * 1024 + 1), "larger than 4 MiB")]
)
def test_an_unreadable_text_is_reported(data: bytes, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.osc"
    path.write_bytes(data)
    (found,) = frontend.load(path).diagnostics
    assert reason in found.message


def test_a_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    path = tmp_path / "bom.osc"
    path.write_bytes(b"\xef\xbb\xbfstruct x\n")
    assert frontend.load(path).diagnostics == ()


def test_errors_of_an_imported_file_are_located_there(tmp_path: Path) -> None:
    main = write(tmp_path, main='import "a.osc"\nstruct y\n', a="struct x:\n    n: int = 1.5\n")
    (found,) = frontend.check(frontend.load(main)).diagnostics
    assert found.primary.span.file.path == tmp_path / "a.osc"
    assert found.primary.span.line == 2


def test_an_installed_package_can_bring_a_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add_entry_points(tmp_path, "lifts", "[seoro.libraries]\nlifts = lifts_for_seoro\n")
    package = tmp_path / "lifts_for_seoro"
    package.mkdir()
    (package / "__init__.py").write_text("raise RuntimeError('loading declarations runs nothing')\n")
    (package / "lifts.osc").write_text("import osc.types\nactor lift\naction lift.go:\n    to: length\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    text = "import osc.lifts\n\nscenario main:\n    l: lift\n    do l.go(3m)\n"
    sources = frontend.load(write(tmp_path, main=text))
    assert tuple(library.name for library in sources.libraries) == ("osc.lifts", "osc.types")
    plan = frontend.lower(frontend.check(sources))
    assert plan.actions["lift.go"].library == "osc.lifts"
    assert "lifts_for_seoro" not in sys.modules


def test_an_invalid_uri_is_reported(tmp_path: Path) -> None:
    loaded = frontend.load(write(tmp_path, main='import "http://[x"\n'))
    assert [found.code for found in loaded.diagnostics] == ["E0203"]


def test_texts_may_come_from_a_given_reader(tmp_path: Path) -> None:
    texts = {tmp_path / "main.osc": 'import "a.osc"\n', tmp_path / "a.osc": "struct x\n"}
    assert [
        module.file.text for module in frontend.load(tmp_path / "main.osc", read=texts.__getitem__).modules
    ] == [
        "struct x\n",
        'import "a.osc"\n',
    ]


@pytest.mark.parametrize("uri", ["my%20file.osc", "file:///my%20file.osc", "./my%20file.osc"])
def test_paths_are_percent_decoded(uri: str) -> None:
    found = path_of(uri)
    assert found is not None and found.name == "my file.osc"
