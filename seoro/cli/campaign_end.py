"""End of a campaign, for notifications."""

from __future__ import annotations

from typing import Any, Final

from seoro.campaign.session import Campaign
from seoro.campaign.state import progress_data
from seoro.cli.exit_status import Exit
from seoro.cli.notifying import ended

_STATUSES: Final = {Exit.PASSED: "passed", Exit.FAILED: "failed", Exit.INTERRUPTED: "cancelled"}


class CampaignEnd:
    """End of a session of a campaign.

    Args:
        campaign: The campaign.

    Attributes:
        status: Exit status; an error unless the session ended regularly.
    """

    def __init__(self, campaign: Campaign) -> None:
        self._campaign = campaign
        self.status = Exit.ERROR

    def content(self, error: BaseException | None) -> dict[str, Any]:
        """Return the result as JSON data.

        Args:
            error: Exception that ended the session, if any.
        """
        state = self._campaign.state
        rate = state.rate(is_complete=state.is_complete)
        bounds = rate.bounds
        return {
            **ended(_STATUSES.get(self.status, "error"), error),
            **progress_data(state),
            "folder": str(self._campaign.folder.absolute()),
            "rate": {
                "share": rate.share,
                "low": None if bounds is None else bounds.low,
                "high": None if bounds is None else bounds.high,
            },
        }
