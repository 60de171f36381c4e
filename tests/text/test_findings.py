"""Formats of findings for CI services."""

import json
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.text.findings import Finding, formatted

PLAIN = Finding("a b.osc", 3, 5, 3, 9, "error", "E0312", "`x` and `y`\n100 % wrong: no, never", "use 1s")
LONG = Finding("c.osc", 1, 1, 2, 4, "info", "E0999", "spans lines")


def test_github_commands_are_escaped_and_have_columns_within_one_line() -> None:
    assert formatted("github", [PLAIN, LONG], {}).splitlines() == [
        "::error file=a b.osc,line=3,endLine=3,col=5,endColumn=9,title=E0312::"
        "`x` and `y`%0A100 %25 wrong: no, never%0Ause 1s",
        "::notice file=c.osc,line=1,endLine=2,title=E0999::spans lines",
    ]
    odd = PLAIN._replace(file="x,y:z.osc", message="", help="")
    assert formatted("github", [odd], {}).startswith("::error file=x%2Cy%3Az.osc,")


def test_sarif_names_rules_and_places() -> None:
    log = json.loads(formatted("sarif", [PLAIN, LONG, PLAIN], {"E0312": "Wrong type"}))
    [run] = log["runs"]
    assert [rule["id"] for rule in run["tool"]["driver"]["rules"]] == ["E0312", "E0999"]
    assert run["tool"]["driver"]["rules"][0]["shortDescription"] == {"text": "Wrong type"}
    assert [result["ruleIndex"] for result in run["results"]] == [0, 1, 0]
    assert [result["level"] for result in run["results"]] == ["error", "note", "error"]
    place = run["results"][0]["locations"][0]["physicalLocation"]
    assert place["artifactLocation"] == {"uri": "a%20b.osc"}
    assert place["region"] == {"startLine": 3, "startColumn": 5, "endLine": 3, "endColumn": 9}
    assert (log["version"], log["$schema"][-23:]) == ("2.1.0", "sarif-schema-2.1.0.json")


@pytest.mark.parametrize("form", ["json", "github", "sarif"])
def test_check_prints_a_format(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "a.osc"
    file.write_text("scenario main:\n    do nothing_known()\n")
    assert main(["check", str(file), "--output-format", form]) == 2
    out = capsys.readouterr().out
    if form == "github":
        assert (
            out == f"::error file={file},line=2,endLine=2,col=8,endColumn=21,title=E0401::unknown scenario or "
            "action `nothing_known`\n"
        )
        return
    found = json.loads(out)
    codes = found[0]["code"] if form == "json" else found["runs"][0]["results"][0]["ruleId"]
    assert codes == "E0401"
