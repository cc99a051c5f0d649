"""Harmonic loads and prescribed motions of mechanical systems: the equations of frequency responses, and the steady state."""
