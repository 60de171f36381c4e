"""Report of a campaign: one HTML file with charts, readable without a network and without scripts."""
