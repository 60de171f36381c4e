"""seoro runs OpenSCENARIO DSL scenarios against simulated and real robots."""
