"""Equations of motion on paper: closed form, C, ODE; dae/, free_body/."""
