"""Fork server of a campaign: `python -m seoro.campaign.pool.template REQUESTS REPORTS FOLDER`.

It loads the scenario and all modules of runs once; workers are forked from it (see `seoro.concurrency.forks`).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from seoro.campaign.pool.worker import work
from seoro.campaign.store.folder import read_campaign
from seoro.campaign.work.job import load_job
from seoro.concurrency.forks.serving import serve_forks


def main(arguments: Sequence[str]) -> None:
    """Fork workers until the campaign ends."""
    requests, reports, folder = int(arguments[0]), int(arguments[1]), Path(arguments[2])
    campaign = read_campaign(folder)
    job = load_job(campaign, folder)
    if campaign.manifest.options.simulator is not None:  # loaded once, for all workers
        import seoro.bridges.launch  # noqa: PLC0415
        import seoro.bridges.wire.all_messages  # noqa: F401, PLC0415
    descriptors = serve_forks(requests, reports)
    if descriptors is not None:
        work(job, *descriptors)


if __name__ == "__main__":
    main(sys.argv[1:])
