"""Rates of samples of poses, shared by options, contracts and messages."""

from __future__ import annotations

from typing import Final

POSE_RATE: Final = 10.0  # [1/s] by default
MAX_POSE_RATE: Final = 50.0  # [1/s], one sample in each tick of a simulator
