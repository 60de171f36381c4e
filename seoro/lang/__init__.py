"""Language front end of OpenSCENARIO DSL 2.2: text to `Plan`, by parsing, checking and lowering."""
