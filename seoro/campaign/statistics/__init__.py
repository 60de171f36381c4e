"""Statistics of campaigns, in pure Python: intervals, sequential tests and comparisons."""
