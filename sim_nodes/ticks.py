"""How often robots do something: in ticks of simulated time, whatever the length of a physics step."""

TICK = 0.02  # [s]
IDLE_TICKS = 50  # from one tick of a robot that has nothing to do to the next
