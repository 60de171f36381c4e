"""The grammar for editors, run as VS Code runs it, and compared with the language.

The tokens need Node.js and `npm install` in `editors/vscode`; without these, only the words are compared.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from seoro.lang import parse_table

ROOT = Path(__file__).parents[2]
EXTENSION = ROOT / "editors/vscode"
GRAMMAR = EXTENSION / "syntaxes/osc.tmLanguage.json"
OURS = [*(ROOT / "scenarios").rglob("*.osc"), *(ROOT / "seoro/lang/library").glob("*.osc")]

needs_node = pytest.mark.skipif(
    shutil.which("node") is None or not (EXTENSION / "node_modules/vscode-textmate").exists(),
    reason="needs node, and `npm install` in editors/vscode",
)

SAMPLE = ROOT / "tests/data/editors/sample.osc"


def tokenise(text: str) -> list[tuple[str, str]]:
    """The tokens of a text without blanks, each with its innermost scope."""
    done = subprocess.run(
        ["node", str(EXTENSION / "test/tokenise.mjs")], input=text, capture_output=True, text=True, check=True
    )
    return [
        (part.strip(), (scopes or [""])[-1].removesuffix(".osc"))
        for line in json.loads(done.stdout)
        for part, scopes in line
        if part.strip()
    ]


def patterns(value: Any) -> list[str]:
    """All regular expressions of a part of the grammar."""
    if isinstance(value, dict):
        own = [value[key] for key in ("match", "begin", "end") if isinstance(value.get(key), str)]
        return own + [found for item in value.values() for found in patterns(item)]
    return [found for item in value for found in patterns(item)] if isinstance(value, list) else []


def test_the_keywords_equal_those_of_the_language() -> None:
    repository = json.loads(GRAMMAR.read_text(encoding="utf-8"))["repository"]
    words = {
        word
        for found in patterns(repository)
        for word in re.findall(r"(?<![\\\w\[{])[A-Za-z_]{2,}", found.replace(r"\b", " "))
    }
    keywords = {word for word in parse_table.load()["literals"] if word[0].isalpha()}
    assert keywords - words == set()
    assert words - keywords - {"xA", "Fa", "ntr", "eE", "start", "end", "fail"} == set()


def test_the_extension_names_files_that_exist() -> None:
    contributes = json.loads((EXTENSION / "package.json").read_text(encoding="utf-8"))["contributes"]
    [language], [grammar] = contributes["languages"], contributes["grammars"]
    assert (EXTENSION / language["configuration"]).exists()
    assert (EXTENSION / grammar["path"]).samefile(GRAMMAR)
    json.loads((EXTENSION / language["configuration"]).read_text(encoding="utf-8"))


@needs_node
def test_the_scopes_are_the_golden_ones() -> None:
    text = "".join(f"{part:40} {scope}\n" for part, scope in tokenise(SAMPLE.read_text(encoding="utf-8")))
    golden = SAMPLE.with_suffix(".scopes")
    if os.environ.get("SEORO_UPDATE_GOLDENS"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


@needs_node
def test_everything_in_our_files_has_a_scope() -> None:
    text = "\n".join(path.read_text(encoding="utf-8") for path in OURS)
    assert [part for part, scope in tokenise(text) if not scope] == []
