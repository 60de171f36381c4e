"""End of a campaign, for notifications."""

from __future__ import annotations

from typing import Any, Final

from seoro.campaign.session import Campaign
from seoro.cli.exit_status import Exit
from seoro.cli.notifying import failure_of

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
        campaign, state = self._campaign, self._campaign.state
        rate = state.rate(is_complete=state.is_complete)
        bounds = rate.bounds
        result = (
            {"status": _STATUSES.get(self.status, "error"), "reason": ""} if error is None else failure_of(error)
        )
        return {
            **result,
            "scenario": campaign.campaign.manifest.shown,
            "folder": str(campaign.folder.absolute()),
            "runs": state.tally.runs,
            "planned": campaign.campaign.runs,
            "ends": {end.value: count for end, count in state.tally.ends.items()},
            "rate": {
                "share": rate.share,
                "low": None if bounds is None else bounds.low,
                "high": None if bounds is None else bounds.high,
            },
            "is_complete": state.is_complete,
            "stopped": None if campaign.stopped is None else campaign.stopped.reason,
            "requirements": list(campaign.campaign.requirements),
        }
