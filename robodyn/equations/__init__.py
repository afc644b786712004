"""Equations of motion on paper: closed form, ODE; DAE form, free bodies, source code (export/), near a state (linearized/)."""
