"""What robots sense, and the noise in it."""
