"""Results of a campaign, derived from its rows: the table, and the report for CI servers."""
