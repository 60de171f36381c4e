"""Programs that are made up: what the runtime promises of every scenario, it has to keep for them."""
