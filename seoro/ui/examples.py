"""Examples that `seoro ui --demo` shows: runs of scenarios that come with seoro."""

from __future__ import annotations

import logging
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Final

from seoro.errors import SeoroError
from seoro.ui.answers import RequestError
from seoro.ui.private_executor import SHOWN
from seoro.ui.site import Site
from seoro.ui.starting import start_run

FOLDER: Final = Path(__file__).parent / "demo"
_SIMULATOR: Final = "mujoco"
_WITH_SIMULATOR: Final = {"file": "around_a_box.osc", "simulator": _SIMULATOR, "rate": 1}
_PLAIN: Final = ({"file": "lift.osc"}, {"file": "late_parcel.osc"})

log = logging.getLogger(__name__)


async def start_examples(site: Site) -> None:
    """Start a run of each example, when the executor of this machine is there."""
    forms: list[dict[str, Any]] = [*_PLAIN]
    if find_spec(_SIMULATOR) is not None:
        forms.insert(0, dict(_WITH_SIMULATOR))
    else:
        log.warning("note: a robot needs a simulator: pip install 'seoro[%s]'", _SIMULATOR)
    await site.places.wait_for(SHOWN)
    for form in forms:
        try:
            await start_run(site, {**form, "place": SHOWN})
        except (RequestError, SeoroError) as error:
            log.error("cannot start %s: %s", form["file"], error)
