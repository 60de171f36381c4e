"""After a failure: single runs of a campaign, found, repeated, and made simpler."""
