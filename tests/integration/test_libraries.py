"""Libraries and models of installed packages, found by their entry points."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.bridges.models import ModelPath
from seoro.cli.main import main
from tests.installed_packages import add_entry_points


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Install a distribution with a library `garden` and models of the same name."""
    package = tmp_path / "site" / "my_garden"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("")
    (package / "weather.py").write_text("def temperature() -> float:\n    return 293.15\n")
    (package / "garden.osc").write_text(
        "import osc.types\n"
        "actor gardener:\n"
        "    tool: string = 'can'\n"
        "    def feels() -> temperature is external weather.temperature()\n"
        "action gardener.water:\n"
        "    plant: string\n"
        "    litres: float = 1.5\n"
    )
    (package / "garden.py").write_text(
        "from seoro import ActionContext, ActionFailed, Actor, action\n"
        "@action('gardener.water')\n"
        "async def water(ctx: ActionContext, gardener: Actor, plant: str, litres: float) -> None:\n"
        "    if plant == 'cactus':\n"
        "        raise ActionFailed('it has had enough')\n"
        "    ctx.log(f'{gardener.name} gives {litres} l to the {plant} with a {gardener.fields[\"tool\"]}')\n"
    )
    add_entry_points(
        tmp_path / "site",
        "my-garden",
        "[seoro.libraries]\ngarden = my_garden.garden\n[seoro.models]\ngarden = my_garden.garden\n",
    )
    monkeypatch.syspath_prepend(str(tmp_path / "site"))
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    for name in [name for name in sys.modules if name.startswith("my_garden")]:
        del sys.modules[name]


def test_an_installed_library_adds_to_the_language(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("test.osc").write_text("import osc.garden\nscenario main:\n    tom: gardener\n    do tom.water('rose')\n")
    assert main(["exec", "test.osc"]) == 0
    assert "tom gives 1.5 l to the rose with a can" in capsys.readouterr().out


def test_an_action_of_an_installed_library_may_fail(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("test.osc").write_text(
        "import osc.garden\nscenario main:\n    tom: gardener\n    do tom.water('cactus')\n"
    )
    assert main(["exec", "test.osc"]) == 1
    assert "it has had enough" in capsys.readouterr().err


def test_methods_of_a_library_are_functions_of_its_package(
    installed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("test.osc").write_text(
        "import osc.garden\nscenario main:\n    tom: gardener\n    x: temperature = tom.feels()\n"
        "    do serial:\n        emit end\n"
    )
    assert main(["exec", "-n", "test.osc"]) == 0
    assert "x = 293.15" in capsys.readouterr().out
    assert "my_garden.weather" in sys.modules


def test_signature_mismatches_are_found_before_the_run(
    installed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    module = installed / "site/my_garden/garden.py"
    module.write_text(module.read_text().replace("litres: float", "litres: int"))
    Path("test.osc").write_text("import osc.garden\nscenario main:\n    do serial:\n        emit end\n")
    assert main(["check", "test.osc"]) == main(["exec", "test.osc"]) == 2
    err = capsys.readouterr().err
    assert "E0604" in err
    assert "`my_garden.garden.water` does not match the action `gardener.water`" in err
    assert "<osc.garden>:5:8" in err


def test_checks_without_code_import_no_library_code(installed: Path) -> None:
    module = installed / "site/my_garden/__init__.py"
    module.write_text("raise RuntimeError")
    Path("test.osc").write_text("import osc.garden\nscenario main:\n    tom: gardener\n    do tom.water('rose')\n")
    assert main(["check", "--no-import", "test.osc"]) == 0
    assert main(["check", "test.osc"]) == 2
    assert "my_garden.garden" not in sys.modules


def test_checks_without_code_accept_variables_of_any_type(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("seoro.libraries").mkdir()
    Path("seoro.libraries/counts.osc").write_text("action count_up:\n    target: string\n    step: int = 1\n")
    Path("seoro.libraries/counts.py").write_text(
        'from seoro import ActionContext, Variable, action\n\n\n@action("count_up")\n'
        "async def count_up(ctx: ActionContext, target: Variable[int], step: int) -> None:\n    target.set(step)\n"
    )
    text = "import osc.counts\nscenario main:\n    var number: int = 0\n    do count_up(number, {})\n"
    Path("test.osc").write_text(text.format("2"))
    assert main(["check", "--no-import", "test.osc"]) == main(["check", "test.osc"]) == 0
    Path("test.osc").write_text(text.format("true"))
    assert main(["check", "--no-import", "test.osc"]) == 2
    assert "E0301" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("nowhere.garden", "Python module `nowhere.garden` of the library"),
        ("my_garden.nowhere", "Python module `my_garden.nowhere` of the library"),
    ],
)
def test_an_entry_point_without_a_module_is_reported(
    entry: str, message: str, installed: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points = installed / "site/my_garden-1.0.dist-info/entry_points.txt"
    points.write_text(f"[seoro.libraries]\ngarden = {entry}\n")
    Path("test.osc").write_text("import osc.garden\nscenario main:\n    do serial:\n        emit end\n")
    assert main(["exec", "test.osc"]) == 2
    assert message in capsys.readouterr().err


def test_two_packages_with_one_library_are_refused(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    add_entry_points(installed / "site", "other", "[seoro.libraries]\ngarden = other.garden\n")
    Path("test.osc").write_text("import osc.garden\nscenario main:\n    do serial:\n        emit end\n")
    assert main(["check", "test.osc"]) == 2
    assert "several installed packages have a library `osc.garden`" in capsys.readouterr().err


def test_an_unknown_library_lists_similar_names(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("test.osc").write_text("import osc.gardens\nscenario main:\n    do serial:\n        emit end\n")
    assert main(["exec", "test.osc"]) == 2
    err = capsys.readouterr().err
    assert "test.osc:1:" in err
    assert "osc.garden" in err


def test_installed_models_are_found(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (installed / "site" / "my_garden" / "rose.sdf").write_text("red")
    assert ModelPath().read("garden://rose.sdf").text == "red"
