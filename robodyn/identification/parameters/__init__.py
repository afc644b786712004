"""Parameters of bodies and motors: their columns along a log, what torques show of them, what can exist."""
