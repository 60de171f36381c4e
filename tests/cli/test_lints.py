"""Warnings of suspicious code, their suppression and their fixes."""

import json
from pathlib import Path

import pytest

from seoro.cli.main import main

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def codes_of(text: str, folder: Path, capsys: pytest.CaptureFixture[str], *options: str) -> list[tuple[int, str]]:
    """Check a text, and return the lines and codes of its messages."""
    file = folder / "a.osc"
    file.write_text(text)
    assert main(["check", "--json", *options, str(file)]) == 0
    return [(item["line"], item["code"]) for item in json.loads(capsys.readouterr().out)]


ONE_SECOND = "        wait elapsed(1s)\n"
BASE = "import osc.types\nimport osc.helpers\n\nscenario main:\n"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (f"    event go\n    do serial:\n{ONE_SECOND}        wait @go\n        log('x')\n", [(8, "E0701")]),
        (f"    event go\n    do serial:\n        emit go\n        wait @go\n        log('x')\n{ONE_SECOND}", []),
        ("    event go is elapsed(1s)\n    do serial:\n        wait @go\n        log('x')\n", []),
        ("    pace: int = 3\n    do serial:\n        wait elapsed(1s)\n        log('pace')\n", [(5, "E0702")]),
        (f"    pace: int = 3\n    keep(pace > 2)\n    do serial:\n{ONE_SECOND}        log('')\n", []),
        ("    event go\n    do serial:\n        wait elapsed(1s)\n        log('x')\n", [(5, "E0703")]),
        ("    do serial:\n        wait elapsed(1s)\n        emit end\n        log('x')\n", [(8, "E0705")]),
        ("    do parallel:\n        wait elapsed(1s)\n        emit end\n        log('x')\n", []),
        ("    do serial:\n        wait rise(2 > 1)\n        wait elapsed(1s)\n        log('x')\n", [(6, "E0706")]),
        ("    do serial:\n        log('x')\n        wait elapsed(3s)\n    with:\n        timeout(2s)\n", [(9, "E0707")]),  # noqa: E501
        ("    do serial:\n        wait elapsed(3s)\n        emit end\n    with:\n        timeout(2s)\n", []),
        ("    do one_of:\n        wait elapsed(3s)\n        log('x')\n    with:\n        timeout(2s)\n", []),
    ],
)  # fmt: skip
def test_suspicious_code_is_found(
    body: str, expected: list[tuple[int, str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert codes_of(BASE + body, tmp_path, capsys) == expected


LABELS = (
    BASE
    + """\
    do serial:
        first:  wait elapsed(1s)
        second: run_process('true', wait_for_shutdown: false)
        process_log_check('second', ['x'])
        wait @first.end  # third
        third: log('x')
        fourth : serial:
            log('y')
"""
)


def test_unused_labels_are_found_where_they_are_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert codes_of(LABELS, tmp_path, capsys) == []
    assert codes_of(LABELS, tmp_path, capsys, "--select", "E0711") == [(11, "E0711")]
    assert main(["check", "--fix", "--select", "E0711", str(tmp_path / "a.osc")]) == 0
    assert (tmp_path / "a.osc").read_text() == LABELS.replace("fourth : ", "")


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("wait_for_data('/scan', 'sensor_msgs.msg.LaserScann')", "did you mean `sensor_msgs.msg.LaserScan`?"),
        ("wait_for_data('/scan', 'sensor_msgs/msg/LaserScan')", ""),
        ("wait_for_data('/scan', 'my_robot_msgs.msg.Anything')", ""),
        ("wait_for_data('/laser scan', 'sensor_msgs.msg.LaserScan')", "below the namespace"),
        ("service_call('/on', 'std_srvs.msg.SetBool', '{}')", "write it as `std_srvs.srv.Trigger`"),
        ("action_call('/go', 'nav2_msgs.action.Spinn', '{}')", "did you mean `nav2_msgs.action.Spin`?"),
        ("assert_topic_latency('/scan', 1s)", ""),
    ],
)
def test_types_and_names_of_ros_are_checked(
    call: str, expected: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "a.osc"
    file.write_text(f"import osc.ros\n\nscenario main:\n    do {call}\n")
    assert main(["check", "--json", str(file)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [item["code"] for item in found] == ["E0415"] * bool(expected)
    assert all(expected in item["help"] for item in found)


def test_actors_and_bases_are_not_unused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    base = "import osc.types\nactor car\n\nscenario base:\n    pace: int = 3\n\n"
    text = f"{base}scenario main:\n    robot: car\n    do wait elapsed(1s)\n"
    assert codes_of(text, tmp_path, capsys) == []


def test_imports_are_used_by_the_names_that_they_declare(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "facade.osc").write_text("import osc.types\nimport osc.helpers\n")
    (tmp_path / "extending.osc").write_text("struct crate\nextend crate:\n    size: int = 1\n")
    text = "scenario main:\n    do wait elapsed(1s)\n"
    assert codes_of(f"import 'facade.osc'\n{text}", tmp_path, capsys) == []
    assert codes_of(f"import osc.types\nimport 'facade.osc'\n{text}", tmp_path, capsys) == [(2, "E0704")]
    assert codes_of(f"import osc.types\nimport 'extending.osc'\n{text}", tmp_path, capsys) == []
    assert main(["check", str(tmp_path / "facade.osc")]) == 0
    assert capsys.readouterr().err == ""


def test_shadowed_names_are_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    crate = "struct crate:\n    size: int = 1\n    def grown(size: int) -> int is expression size + 1\n"
    main_ = "scenario main:\n    pace: int = 4\n    keep(pace > 1)\n    do emit end\n"
    text = f"global pace: int = 3\n\n{crate}\n{main_}"
    assert codes_of(text, tmp_path, capsys) == [(5, "E0710"), (8, "E0710")]
    assert (
        codes_of(
            text.replace("global pace", "global rate").replace("(size", "(by").replace("size + 1", "by + 1"),
            tmp_path,
            capsys,
        )
        == []
    )


def test_files_with_errors_have_no_lints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text(BASE + "    event go\n    do nothing_known()  # noqa\n")
    assert main(["check", "--json", str(file)]) == 2
    assert [item["code"] for item in json.loads(capsys.readouterr().out)] == ["E0401"]


WAITING = (
    BASE + "    event go\n    do serial:\n        wait elapsed(1s)\n        log('# noqa')\n        wait @go{}\n"
)


@pytest.mark.parametrize(
    ("comment", "expected"),
    [
        ("", ["E0701"]),
        ("  # noqa", []),
        ("  # a program emits it  # noqa: E0701", []),
        ("  # NOQA: e0701", []),
        ("  # noqa: E0702", ["E0701", "E0709"]),
        ("  # noqa: E0701, E0702", ["E0709"]),
        ("  # noqa: E0701, E0799", ["E0708"]),
        ("  # noqa: E0701, E0391", []),
    ],
)
def test_comments_suppress_warnings_of_their_line(
    comment: str, expected: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert [code for _, code in codes_of(WAITING.format(comment), tmp_path, capsys)] == expected


def test_comments_of_imported_files_hold(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "b.osc").write_text("struct crate:\n    name: string = '50\\%'  # noqa: E0140\n")
    text = "import 'b.osc'\n\nscenario main:\n    do emit end\n"
    assert codes_of(text, tmp_path, capsys) == [(1, "E0704")]


def test_warnings_are_chosen_by_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = WAITING.format("").replace("    do", "    pace: int = 3\n    do")
    assert codes_of(text, tmp_path, capsys, "--ignore", "E0701") == [(6, "E0702")]
    assert codes_of(text, tmp_path, capsys, "--select", "e0701,E0703") == [(10, "E0701")]
    with pytest.raises(SystemExit):
        main(["check", "--ignore", "E0799", str(tmp_path / "a.osc")])
    assert "unknown code `E0799`" in capsys.readouterr().err


TO_FIX = """\
# The first line.
import osc.types
import osc.helpers
import osc.nav2  # for later

scenario main:
    do serial:  # noqa: E0702
        wait elapsed(1s)  # noqa: E0703 for people
"""


def test_fixes_keep_everything_else(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text(TO_FIX)
    assert main(["check", "--fix", "--diff", str(file)]) == 1
    assert "-import osc.helpers\n" in capsys.readouterr().out
    assert file.read_text() == TO_FIX
    assert main(["check", "--fix", "--ignore", "E0709", str(file)]) == 0
    fixed = TO_FIX.replace("import osc.helpers\n", "")
    assert file.read_text() == fixed
    fixed = fixed.replace("  # noqa: E0702", "")
    for _ in range(2):
        assert main(["check", "--fix", str(file)]) == 0
        assert file.read_text() == fixed
    assert main(["check", "--fix", "--diff", str(file)]) == 0


@pytest.mark.parametrize("options", [["--diff"], ["--fix", "-"]])
def test_invalid_requests_for_fixes(
    options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.osc").write_text(TO_FIX)
    assert main(["check", *options, str(tmp_path / "a.osc")]) == 2
    assert "--fix" in capsys.readouterr().err


def test_the_published_scenarios_are_not_suspicious(capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", "--no-import", "--json", str(SCENARIOS)])
    found = json.loads(capsys.readouterr().out)
    assert [item for item in found if item["code"].startswith("E07")] == []
