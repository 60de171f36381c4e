"""Engine of this machine: processes that a fork server makes, each with its own simulator."""
