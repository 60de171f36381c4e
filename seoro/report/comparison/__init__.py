"""Page of `seoro compare`: two runs beside each other, without JavaScript."""
