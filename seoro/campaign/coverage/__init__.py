"""Coverage across the runs of campaigns: items and their bins, counts, and bins that constraints exclude."""
