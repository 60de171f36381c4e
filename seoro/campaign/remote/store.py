"""Rows and folders of runs of other machines, stored by the coordinator."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from seoro.campaign.remote.rows import Checker, kept_folder
from seoro.campaign.runs import Row
from seoro.campaign.store.folder import CampaignFolder, shard
from seoro.campaign.store.lines import Appender


class RemoteStore:
    """Shard of an engine, with the folders of its kept runs; close it at the end.

    Args:
        folder: Folder of the campaign.
        name: Name of the shard.

    Raises:
        OSError: The shard cannot be opened.

    Attributes:
        checker: Checks the rows before they are stored.
    """

    def __init__(self, folder: CampaignFolder, name: str) -> None:
        self.checker = Checker(folder.campaign.digest, folder.campaign.version)
        self._folder = folder.folder
        self._name = name
        self._rows = Appender(shard(self._folder, name))

    @contextmanager
    def kept(self, run: int) -> Iterator[Path]:
        """Yield a new folder for the files of a run, which is moved to its place if the block succeeds.

        Raises:
            OSError: It cannot be written.
        """
        place = self._folder / kept_folder(run)
        new = place.with_name(f".{place.name}-{self._name}")
        shutil.rmtree(new, ignore_errors=True)
        new.mkdir(parents=True)
        try:
            yield new
            shutil.rmtree(place, ignore_errors=True)
            new.replace(place)
        finally:
            shutil.rmtree(new, ignore_errors=True)

    def append(self, row: Row) -> None:
        """Append a row.

        Raises:
            OSError: It cannot be written.
        """
        self._rows.append(row.to_line())

    def close(self) -> None:
        """Close the shard."""
        self._rows.close()
