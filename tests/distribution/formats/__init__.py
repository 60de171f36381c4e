"""Files and messages of released versions, kept in `tests/data/formats/VERSION`, and their readers of today."""
