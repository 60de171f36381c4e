"""Margins of paths by the localisation: a robot that is unsure of its place keeps away where there is room.

The localisation states a deviation of several centimetres even when it is right within two. So usual deviations
add nothing. Margins grow in steps, so that paths and fields of costs last for some time.
"""

from __future__ import annotations

from sim_nodes.robots.navigation import NavigationDeclaration

USUAL = 0.12  # [m] of stated deviation up to which paths have no further margin
STEP = 0.05  # [m]
MOST = 0.2  # [m]; more lengthens paths and does not prevent more contacts


def further_margin(deviation: float) -> float:
    """Return the margin of a path beyond the usual one [m].

    Args:
        deviation: Stated standard deviation of the localised position [m].
    """
    return min(MOST, STEP * max(0, round((deviation - USUAL) / STEP)))


def widened(parameters: NavigationDeclaration, margin: float) -> NavigationDeclaration:
    """Return parameters by which costs near obstacles decrease over a length that is longer by a margin [m]."""
    if not margin or not parameters.cost_scaling_factor:
        return parameters
    factor = 1.0 / (1.0 / parameters.cost_scaling_factor + margin)
    return parameters.model_copy(update={"cost_scaling_factor": factor})
