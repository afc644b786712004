"""Equations of motion on paper: closed form, ODE, DAE form (dae/), free bodies, source code, and near a state."""
