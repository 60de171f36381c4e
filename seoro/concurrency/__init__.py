"""Background tasks, conditions and a steady clock, for asyncio and anyio. May import nothing else of seoro."""
