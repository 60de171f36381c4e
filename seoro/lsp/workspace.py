"""Files of the editor's workspace, for requests beyond the open documents."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from seoro.files.inputs import resolved
from seoro.lang.loader import read_file
from seoro.lsp.analysis import Analysis, analyse
from seoro.lsp.documents import Texts

MAX_FILES = 2000  # searched in a workspace
SUFFIX = ".osc"


def files_with(words: Sequence[str], folders: Iterable[Path]) -> Iterator[Path]:
    """Yield the scenario files that contain one of the words, without hidden folders."""
    seen = 0
    for folder in folders:
        for where, below, names in os.walk(folder):
            below[:] = sorted(name for name in below if not name.startswith("."))
            for name in sorted(names):
                if not name.endswith(SUFFIX):
                    continue
                seen += 1
                if seen > MAX_FILES:
                    return
                path = Path(where, name)
                text = read_file(path)
                if isinstance(text, str) and any(word in text for word in words):
                    yield resolved(path)


def analyse_users(
    words: Sequence[str], folders: Iterable[Path], texts: Texts, known: Iterable[Analysis]
) -> list[Analysis]:
    """Analyse files of the workspace that may use one of the names and are in no known analysis."""
    found = list(known)
    seen = {path for analysis in found for path in analysis.files.by_path}
    for path in files_with(words, folders):
        if path not in seen:
            analysis = analyse(path, texts)
            found.append(analysis)
            seen |= analysis.files.by_path.keys()
    return found
