"""The equations of motion: recursions, effects, loops, plans, inverse and forward dynamics, self-checks."""
