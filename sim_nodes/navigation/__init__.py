"""Navigation of wheeled robots in simulated time: maps, localisation, planning, control."""
