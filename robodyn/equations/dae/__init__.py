"""The DAE form: maximal coordinates, constraints with multipliers, its reduction to the ODE."""
