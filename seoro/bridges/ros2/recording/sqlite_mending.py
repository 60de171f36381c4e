"""SQLite files whose writer was killed in the middle of a write.

Until a program that may write the file undoes or completes that write, its content is not consistent. Readers such
as rosbags do not notice.
"""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Final

from seoro.bridges.ros2.recording.errors import UnreadableBag

_JOURNALS: Final = ("-journal", "-wal")  # ends of the names of SQLite's files with unfinished writes


def check_complete(file: Path) -> None:
    """Check that no write of a file is unfinished.

    Raises:
        UnreadableBag: A write is.
    """
    for end in _JOURNALS:
        journal = file.with_name(file.name + end)
        if journal.is_file() and journal.stat().st_size:
            raise UnreadableBag(
                f"{file} has an unfinished write: its recorder was killed, or is still writing",
                help=f"once it has ended: seoro bag {file.parent} --repair",
            )


def mend(file: Path) -> None:
    """Undo or complete an unfinished write.

    Raises:
        UnreadableBag: The file is being written, or is not an SQLite file.
    """
    try:
        with closing(sqlite3.connect(file, timeout=0.0)) as database:
            database.execute("SELECT count(*) FROM sqlite_schema").fetchone()  # SQLite does it before it reads
    except sqlite3.OperationalError as error:
        raise UnreadableBag(f"{file} is still being written: {error}") from None
    except sqlite3.DatabaseError as error:
        raise UnreadableBag(f"{file} is damaged, or not an SQLite file: {error}") from None
