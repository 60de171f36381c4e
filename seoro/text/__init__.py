"""Text of other parties, made safe for terminals and logs. May import nothing else of seoro."""
