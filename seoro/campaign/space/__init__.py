"""The space of a campaign: which parameters vary, and over which values."""
