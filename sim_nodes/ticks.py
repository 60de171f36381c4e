"""Ticks: the period of everything that robots do, independent of the length of a physics step."""

TICK = 0.02  # [s]
IDLE_TICKS = 50  # between two updates of an idle robot
