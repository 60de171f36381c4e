"""From text to plan: parsing, checking and lowering of OpenSCENARIO DSL 2.2."""
