"""Runs of a campaign as scenario files that run by themselves."""

from pathlib import Path

import pytest

from seoro.campaign.after.exec_options import words_beyond_directives
from seoro.campaign.emit import Emitter
from seoro.campaign.emit_options import place_conftest
from seoro.cli.main import main
from seoro.embed import load
from seoro.embed.options import Lab, Options, Ros, Simulator
from seoro.errors import UsageError

TEXT = """# seoro: timeout 60s
# seoro: world none.yaml

import osc.helpers
import osc.shared
import "near/inside.osc"
import "../outside.osc"

scenario helper:
    do log("x")

# A comment.
# seoro: seed 1, 2
# seoro: parametrize load=[1, 2]
# seoro: expect passed
scenario main:
    load: int
    name: string
    keep(load in [3, 4])
    do serial:
        shared()
        inside()
        outside()
        compare(load, "==", 4)
        compare(name, "==", "a  b")
"""


def action(name: str, imported: str = "") -> str:
    return f'{imported}import osc.helpers\nscenario {name}:\n    do log("{name}")\n'


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "tests"
    (folder / "near").mkdir(parents=True)
    (folder / "seoro.libraries").mkdir()
    (folder / "main.osc").write_text(TEXT.replace("# seoro: world none.yaml\n", ""))
    (folder / "near" / "inside.osc").write_text(action("inside", 'import "../../far.osc"\n'))
    (folder / "seoro.libraries" / "shared.osc").write_text(action("shared"))
    (tmp_path / "outside.osc").write_text(action("outside"))
    (tmp_path / "far.osc").write_text(action("far"))
    monkeypatch.chdir(tmp_path)
    return folder


OPTIONS = Options(overrides={"name": '"a  b"'})


def run(file: Path, *arguments: str) -> int:
    return main(["exec", str(file), "--clock", "virtual", *arguments])


@pytest.mark.parametrize("place", ["tests", "smoke/deep"])
def test_a_written_file_runs_without_options(home: Path, place: str, capsys: pytest.CaptureFixture[str]) -> None:
    emitter = Emitter(load(home / "main.osc"), OPTIONS, Path(place))
    good = emitter.write("good.osc", {"load": "4"}, 7, ["Run 12."])
    bad = emitter.write("bad.osc", {"load": "3"}, 7)
    assert (run(good.path), run(bad.path)) == (0, 1)
    assert "seed 7" in capsys.readouterr().out


def test_its_directives_replace_those_of_the_original(home: Path) -> None:
    written = Emitter(load(home / "main.osc"), OPTIONS, home).write("one.osc", {"load": "4"}, 7, ["Run 12."])
    lines = written.path.read_text().splitlines()
    assert lines[0] == "# seoro: timeout 60s"
    above = lines[lines.index("# A comment.") : lines.index("scenario main:")]
    assert above == [
        "# A comment.",
        "# seoro: expect passed",
        "# Written by seoro campaign.",
        "# Run 12.",
        "# seoro: seed 7",
        '# seoro: set name="a  b"',
        "# seoro: set load=4",
    ]
    original = (home / "main.osc").read_text().splitlines()
    for number, text in enumerate(original, start=1):
        line = written.line_of(number)
        assert lines[line - 1] == text if line else text.startswith("# seoro: ")


def test_a_file_of_the_user_is_not_replaced(home: Path) -> None:
    emitter = Emitter(load(home / "main.osc"), OPTIONS, home)
    for _ in range(2):
        emitter.write("one.osc", {"load": "4"}, 7)
    with pytest.raises(UsageError, match="was not written by seoro campaign"):
        emitter.write("main.osc", {"load": "4"}, 7)
    (home.parent / "smoke" / "near").mkdir(parents=True)
    (home.parent / "smoke" / "near" / "inside.osc").write_text("")
    with pytest.raises(UsageError, match="differs from the file of the scenario"):
        Emitter(load(home / "main.osc"), OPTIONS, Path("smoke"))


def test_simulator_and_world_are_directives(home: Path) -> None:
    (home.parent / "hall.yaml").write_text("")
    simulator = Simulator("mujoco", world=f"{home.parent / 'hall.yaml'}?wall_height=2")
    options = Options(overrides={"name": '"a  b"'}, simulator=simulator)
    written = Emitter(load(home / "main.osc"), options, Path("smoke")).write("one.osc", {"load": "4"}, 7)
    text = written.path.read_text()
    assert "# seoro: simulators mujoco\n# seoro: world ../hall.yaml?wall_height=2\n" in text
    assert words_beyond_directives(options) == ["--rate", "max"]


def test_other_options_belong_to_the_command() -> None:
    assert words_beyond_directives(Options(name="x", clock="virtual", lab=Lab("lab.yaml"))) == [
        "--scenario", "x", "--clock", "virtual", "--lab", "lab.yaml"
    ]  # fmt: skip
    ros = Options(ros=Ros("tcp/a:1", 3), simulator=Simulator("ros", world="w.sdf", rate=2.0))
    assert words_beyond_directives(ros) == [
        "--ros",
        "tcp/a:1?domain=3",
        "--sim",
        "ros",
        "--world",
        "w.sdf",
        "--rate",
        "2.0",
    ]
    saved = Options(simulator=Simulator(endpoint="tcp/b:1", snapshot="s", model_path=["m"], rate=1.0))
    assert words_beyond_directives(saved) == ["--connect", "tcp/b:1", "--from-snapshot", "s", "--model-path", "m"]


def options_in(folder: Path) -> dict[str, object]:
    """Return the options that the `conftest.py` of a folder adds."""
    file = folder / "conftest.py"
    names = {"__file__": str(file)}
    exec(file.read_text().replace("@pytest.fixture\n", ""), names)
    found: dict[str, object] = names["osc_options"]({"seed": 3})  # type: ignore[operator]
    return found


@pytest.mark.parametrize(
    "options",
    [
        {"lab": Lab("lab.yaml", rate="max", model_path=["models"])},
        {"ros": Ros("tcp/a:1", 3, "ros2dds", ["msgs"]), "simulator": Simulator("ros", world="w.sdf", rate=2.0)},
        {"simulator": Simulator(endpoint="tcp/b:1", snapshot="s", world="hall"), "clock": "sim"},
    ],
)
def test_pytest_gets_options_that_directives_do_not_have(home: Path, options: dict[str, object]) -> None:
    (home / "smoke").mkdir()
    assert place_conftest(Options(**options), home / "smoke")  # type: ignore[arg-type]
    found = options_in(home / "smoke")
    assert found.pop("seed") == 3

    shown = {key: repr(value).replace(f"{home}/smoke/../../", "") for key, value in found.items()}
    assert shown == {key: repr(value) for key, value in options.items()}


def test_a_needless_conftest_is_removed_and_that_of_the_user_stays(home: Path) -> None:
    plain = Options(simulator=Simulator("mujoco", world="hall"))
    assert place_conftest(Options(lab=Lab("lab.yaml")), home)
    assert not place_conftest(plain, home) and not (home / "conftest.py").exists()
    (home / "conftest.py").write_text("# mine\n")
    assert not place_conftest(plain, home)
    with pytest.raises(UsageError, match="was not written by seoro campaign"):
        place_conftest(Options(lab=Lab("lab.yaml")), home)
    assert (home / "conftest.py").read_text() == "# mine\n"
