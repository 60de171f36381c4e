"""Output files of a run of a campaign, in the folder that it may keep."""

from __future__ import annotations

from contextlib import AbstractAsyncContextManager, nullcontext
from pathlib import Path

from seoro.bridges.executor.messages import BundledFilm
from seoro.embed.parquet import is_parquet_installed, is_table, to_parquet
from seoro.embed.runs import Run
from seoro.embed.video import NAME, Recording, VideoOptions


def recording(run: Run, film: BundledFilm | None, folder: Path) -> AbstractAsyncContextManager[Recording | None]:
    """Record a video of a run while the block lasts.

    Args:
        run: The run.
        film: The video; None for none.
        folder: Folder for it.
    """
    return nullcontext() if film is None else run.recording(VideoOptions(**film.model_dump()), folder / NAME)


async def save_artifacts(run: Run, folder: Path, *, parquet: bool) -> None:
    """Write the artifacts of the simulator: measurements, trajectories and pictures.

    Args:
        run: The run, which has ended.
        folder: Folder for them.
        parquet: Whether to write tables as Parquet, too.

    Raises:
        OSError: A file cannot be written.
    """
    for artifact in await run.artifacts():
        path = folder / Path(artifact.name).name
        path.write_bytes(artifact.data)
        if parquet and is_table(path.name) and is_parquet_installed():
            path.with_suffix(".parquet").write_bytes(to_parquet(artifact.data))
