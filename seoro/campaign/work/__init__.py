"""Work of a campaign: one run after another in one process, each to a row of the table."""
