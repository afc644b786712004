"""Closed chains: their equations, which of them are independent, starts that are closed."""
