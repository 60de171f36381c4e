"""How often robots do something: in ticks of simulated time, whatever the length of a physics step."""

TICK = 0.02  # [s]
