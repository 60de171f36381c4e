"""Where executors are, unless somebody says otherwise."""

from __future__ import annotations

from typing import Final

ENDPOINT: Final = "tcp/127.0.0.1:7470"
