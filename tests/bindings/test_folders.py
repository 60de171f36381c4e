"""Libraries in the folder `seoro.libraries` beside a scenario."""

import sys
from pathlib import Path

import pytest

import seoro
from seoro.embed import prepare
from seoro.embed.options import Options
from tests.bindings.conftest import Check

DECLARATION = "action greet\n"
PYTHON = """from seoro import ActionContext, action
from .words import WORD

@action("greet")
async def greet(ctx: ActionContext) -> None:
    ctx.log(WORD)
"""
MAIN = "import osc.hello\nscenario main:\n    do greet()\n"


def write(folder: Path, word: str) -> Path:
    library = folder / "seoro.libraries"
    library.mkdir(parents=True)
    (library / "hello.osc").write_text(DECLARATION)
    (library / "hello.py").write_text(PYTHON)
    (library / "words.py").write_text(f"WORD = {word!r}\n")
    (folder / "main.osc").write_text(MAIN)
    return folder / "main.osc"


async def logs(file: Path) -> list[str]:
    async with seoro.start(seoro.load(file), clock="virtual") as run:
        return [record["message"] async for record in run.trace() if record["kind"] == "log"]


async def test_libraries_of_two_scenarios_do_not_clash(tmp_path: Path) -> None:
    path = list(sys.path)
    assert await logs(write(tmp_path / "a", "one")) == ["one"]
    assert await logs(write(tmp_path / "b", "two")) == ["two"]
    assert sys.path == path
    assert not {"hello", "words"} & sys.modules.keys()


async def test_a_library_may_be_a_package(tmp_path: Path) -> None:
    file = write(tmp_path, "three")
    library, package = tmp_path / "seoro.libraries", tmp_path / "seoro.libraries/hello"
    package.mkdir()
    (library / "hello.osc").rename(package / "hello.osc")
    (library / "hello.py").rename(package / "__init__.py")
    (library / "words.py").rename(package / "words.py")
    assert await logs(file) == ["three"]


def test_the_folder_belongs_to_the_scenario_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path / "a", "one")
    other = tmp_path / "b/main.osc"
    other.parent.mkdir()
    other.write_text(MAIN)
    monkeypatch.chdir(tmp_path / "a")
    with pytest.raises(seoro.InvalidScenario, match=r"library `osc\.hello` not found"):
        seoro.load(other)


def test_a_near_name_is_given(tmp_path: Path) -> None:
    file = write(tmp_path, "one")
    file.write_text(MAIN.replace("osc.hello", "osc.helo"))
    with pytest.raises(seoro.InvalidScenario, match=r"did you mean `osc\.hello`"):
        seoro.load(file)


def test_a_name_of_seoros_own_is_refused(check_files: Check) -> None:
    files = {"main.osc": "import osc.ros\n", "seoro.libraries/ros.osc": "struct mine\n"}
    [found] = check_files(files).checked.diagnostics
    assert found.code == "E0204"
    assert found.message.endswith("seoro.libraries/ros.osc` cannot replace `osc.ros`, a library of seoro")


def test_a_library_of_declarations_alone_needs_no_python(check_files: Check) -> None:
    files = {
        "main.osc": "import osc.kinds\nscenario main:\n    k: kind\n",
        "seoro.libraries/kinds.osc": "struct kind:\n    x: int = 1\n",
    }
    assert check_files(files).checked.diagnostics == ()


def test_errors_in_its_declarations_are_shown_by_the_name_of_the_file(check_files: Check) -> None:
    files = {
        "main.osc": "import osc.kinds\n",
        "seoro.libraries/kinds.osc": 'import "more.osc"\nstruct kind:\n    x: inn\n',
    }
    files["seoro.libraries/more.osc"] = "struct other:\n    y: inn\n"
    names = [Path(found.position[0]).name for found in check_files(files).checked.errors]
    assert names == ["kinds.osc", "more.osc"]


@pytest.mark.parametrize("name", ["seoro.libraries/one.osc", "seoro.libraries/two/two.osc"])
def test_a_library_can_be_checked_by_itself(name: str, check_files: Check, tmp_path: Path) -> None:
    check_files(
        {
            "main.osc": "import osc.one\n",
            "seoro.libraries/one.osc": "import osc.two\nstruct a:\n    def f() -> int is external two.f()\n",
            "seoro.libraries/two/two.osc": "import osc.one\nstruct b:\n    def f() -> int is external two.f()\n",
            "seoro.libraries/two/__init__.py": "def f() -> int:\n    return 1\n",
        }
    )
    for file in (tmp_path / "main.osc", tmp_path / name):
        assert seoro.load(file).checked.diagnostics == ()


def test_nothing_of_it_is_run_unless_it_may_be_imported(check_files: Check, tmp_path: Path) -> None:
    ran = tmp_path / "ran"
    files = {
        "main.osc": "import osc.hello\nimport osc.helpers\n"
        "scenario main:\n    def f() -> int is external beside.f()\n"
        "    do serial:\n        greet()\n        log(3)\n",
        "beside.py": f"import pathlib; pathlib.Path({str(ran)!r}).touch()\n",
        "seoro.libraries/hello.osc": DECLARATION,
        "seoro.libraries/hello.py": f"import pathlib; pathlib.Path({str(ran)!r}).touch()\n",
    }
    assert check_files(files, import_python=False).checked.diagnostics == ()
    assert not ran.exists()
    assert [found.code for found in check_files(files).checked.errors] == ["E0607"]
    assert ran.exists()


async def test_a_program_may_give_modules_of_its_own(tmp_path: Path) -> None:
    from types import ModuleType

    @seoro.action("greet")
    async def greet(ctx: seoro.ActionContext) -> None:
        ctx.log("mine")

    module = ModuleType("mine")
    vars(module)["greet"] = greet
    scenario = seoro.load(write(tmp_path, "theirs"), modules=[module])
    async with prepare(scenario, Options(clock="virtual")) as run, run.running():
        assert [record["message"] async for record in run.trace() if record["kind"] == "log"] == ["mine"]
