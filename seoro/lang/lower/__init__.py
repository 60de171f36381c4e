"""From what was checked to the plan of one scenario: its entry, its overrides, and all that it reaches."""
