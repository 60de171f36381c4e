"""Neighbours of failed runs."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from seoro.campaign.after.neighbourhood import Neighbourhood
from seoro.campaign.report.page import write_report
from seoro.campaign.runs import End, Row
from seoro.campaign.space.axes import Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Told
from seoro.cli.main import main
from tests.campaign.shrunk import FAILURE, carry_out, told
from tests.campaign.spaces import SPAN, listed, ranged
from tests.campaign.test_report import Reader

SPACE = Space(
    (
        ranged("load"),
        ranged("count", 0, 1000, is_whole=True),
        listed("mode", 4),
        Choices("floor", ('"ice"', '"wood"', '"mud"'), None, SPAN),
        ranged("wind"),
    ),
    is_feasible=lambda values: values["floor"] != '"mud"' and float(values["wind"]) > 0.25,
)
VALUES = {"load": "0.42", "count": "500", "mode": "3", "floor": '"ice"', "wind": "0.3"}


def fails(values: Mapping[str, str]) -> bool:
    is_within = 0.3 < float(values["load"]) < 0.9 and int(values["count"]) < 503
    return is_within and values["mode"] != "1" and values["floor"] == '"ice"'


def test_the_first_value_that_passes_is_found_in_both_directions() -> None:
    around = Neighbourhood(7, VALUES, FAILURE)
    ran = carry_out(around, fails, SPACE)
    assert around.has_repeated and ran[0].values == VALUES
    ends = {
        path: tuple(side and (side.end, side.ending, side.failing) for side in sides)
        for path, sides in around.directions.items()
    }
    assert ends == {
        "load": (("0.3", "passes", "0.31"), ("0.9", "passes", "0.89")),
        "count": ((None, "", "0"), ("503", "passes", "502")),
        "mode": (("1", "passes", "2"), None),
        "wind": (("0.25", "excluded", "0.26"), (None, "", "1.0")),
    }
    assert around.others == {"floor": {'"wood"': "passes", '"mud"': "excluded"}}
    assert [path for path in VALUES if around.matters(path)] == ["load", "count", "mode", "floor"]
    assert len(ran) < 60
    changed = [sum(point.values[path] != VALUES[path] for path in VALUES) for point in ran[1:]]
    assert set(changed) == {1}, "one parameter at a time"


def test_another_failure_is_not_the_same() -> None:
    around = Neighbourhood(7, {"load": "0.5"}, FAILURE)
    batches = around.batches(Space((ranged("load"),)), 1)
    first = next(batches)
    second = batches.send([told(first[0], lambda _: True)])
    row = Row(1, "", 1, 1, 1, End.FAILED, reason_key="fallen", where="main.osc:7:1")
    with pytest.raises(StopIteration):
        batches.send([Told(point, (row,)) for point in second])
    low, high = around.directions["load"]
    assert low is not None and high is not None
    assert (low.end, low.ending, high.end, high.ending) == ("0.49", "other failure", "0.51", "other failure")
    assert around.matters("load")


def test_a_failure_that_does_not_repeat_has_no_neighbours() -> None:
    around = Neighbourhood(7, {"load": "0.5"}, FAILURE)
    assert len(carry_out(around, lambda _: False, Space((ranged("load"),)))) == 1
    assert not around.has_repeated


def test_a_table_shows_the_neighbours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.helpers
scenario main:
    load: int
    keep(load in [0, 2, 5, 9])
    mode: string
    keep(mode in ["a", "b"])
    do compare(load, "<", 3)
""")
    assert main(["campaign", "run", "main.osc", "--clock", "virtual", "--seed", "2", "-j", "1"]) == 1
    capsys.readouterr()
    assert main(["campaign", "neighbours", "campaign", "5", "-j", "1"]) == 0
    lines = [line.split("  ") for line in capsys.readouterr().out.splitlines()[-2:]]
    cells = [[cell.strip() for cell in line if cell.strip()] for line in lines]
    assert cells == [["load", "5", "passes at 2", "fails to 9", "yes"], ["mode", '"a"', 'fails with "b"', "no"]]
    report = write_report(Path("campaign")).read_text()
    assert "Neighbours of run 5" in report and "<td>passes at 2</td><td>fails to 9</td><td>yes</td>" in report
    page = Reader()
    page.feed(report)
    assert not page.open and "Failed runs in detail" in page.headings
    Path("campaign/neighbours/000005/neighbours.json").write_text("{}")
    assert main(["campaign", "report", "campaign"]) == 2
    assert "neighbours.json: invalid result: Field required" in capsys.readouterr().err
    assert main(["campaign", "neighbours", "campaign", "1"]) == 2
    assert "expected a failed run" in capsys.readouterr().err
