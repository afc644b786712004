"""A robot near one state: linear equations, equilibria, modes."""
