"""Code blocks are read as pages show them, and none escapes."""

from pathlib import Path

from tests.tools.code_blocks import blocks_in, commands_in, is_covered, matches

PAGE = """# Page

`folder/lab.yaml`:

```yaml
a: 1
```

<!-- not run: needs a robot -->
```sh
seoro exec x.osc
```

<!-- exit status: 2 -->
```console
$ seoro check \\
    a.osc
error
$ seoro ps
```

- item

  ```yaml
  b: 2
  ```
"""


def test_blocks_have_names_reasons_and_statuses(tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text(PAGE)
    named, excused, console, plain = blocks_in(tmp_path / "page.md")
    assert (named.name, named.language, named.text, named.line) == ("folder/lab.yaml", "yaml", "a: 1\n", 5)
    assert (excused.reason, excused.name) == ("needs a robot", "")
    assert console.status == 2
    assert list(commands_in(console)) == [("seoro check      a.osc", ["error"]), ("seoro ps", [])]
    assert plain.text == "b: 2\n"
    assert [is_covered(block, None) for block in (named, excused, console, plain)] == [True, True, True, False]


def test_output_is_covered_only_below_a_program(tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text("```python\nprint(1)\n```\n\n```text\n1\n```\n\n```text\n2\n```\n")
    program, printed, other = blocks_in(tmp_path / "page.md")
    assert is_covered(printed, program)
    assert not is_covered(other, printed)


def test_dots_stand_for_lines_and_for_parts_of_a_line() -> None:
    assert matches(["a", "...", "z in ... s"], "a\n\nb\nc\nz in 1.5 s\n")
    assert matches(["..."], "")
    assert not matches(["a", "..."], "b\na\n")
    assert not matches(["z in ... s"], "z in 1.5 s\nmore\n")
