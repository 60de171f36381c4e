"""Configuration of the documentation site, which `make docs` builds with Sphinx."""

import sys
from pathlib import Path

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Text, Whitespace
from sphinx.application import Sphinx
from sphinx.highlighting import lexers

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from seoro import __version__  # noqa: E402
from seoro.lang import parse_table  # noqa: E402
from tests.tools.reference import insert  # noqa: E402

project = "seoro"
version = release = __version__
copyright = "the authors of seoro, Apache License 2.0"

extensions = ["myst_parser", "sphinx_copybutton"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build", "decisions"]  # decisions are for the team
nitpicky = True

myst_heading_anchors = 4
myst_enable_extensions = ["deflist", "substitution"]

html_theme = "furo"  # search, and a dark mode that follows the system
html_title = f"seoro {__version__}"
html_show_sphinx = False
html_theme_options = {"navigation_with_keys": True, "top_of_page_buttons": []}
copybutton_prompt_text = "$ "
copybutton_only_copy_prompt_lines = True

KEYWORDS = tuple(text for text in parse_table.load()["literals"] if text[0].isalpha())


class OscLexer(RegexLexer):
    """Highlights OpenSCENARIO DSL."""

    name = "OpenSCENARIO DSL"
    aliases = ("osc",)
    tokens = {  # noqa: RUF012
        "root": [
            (r"#.*", Comment),
            (r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', String),
            (r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)([a-zA-Z]\w*)?", bygroups(Number, Name.Constant)),
            (r"@[\w.]+", Name.Label),
            (words(KEYWORDS, prefix=r"\b", suffix=r"\b"), Keyword),
            (r"\s+", Whitespace),
            (r"[-+*/%<>=!?]+|\.\.", Operator),
            (r"[()\[\]{}:,.]", Punctuation),
            (r"\w+", Name),
            (r".", Text),
        ]
    }


def generate(app: Sphinx, name: str, source: list[str]) -> None:
    """Insert the generated parts of a page."""
    source[0] = insert(source[0])


def setup(app: Sphinx) -> None:
    """Connect the lexer and the generators."""
    lexers["osc"] = OscLexer()
    app.connect("source-read", generate)
