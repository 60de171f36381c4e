"""Values of scenarios, environments and conversions. It imports no other folder of the runtime."""
