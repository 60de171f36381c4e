"""The scenarios of this folder need images."""

import pytest

from seoro.embed.options import OptionFields


@pytest.fixture
def osc_options(osc_options: OptionFields, draws: None) -> OptionFields:
    """Skip where nothing can be rendered."""
    return osc_options
