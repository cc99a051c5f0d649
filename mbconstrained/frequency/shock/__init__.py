"""Shock: peaks of functions of time (``extrema``), and shock response spectra (``response_spectrum``)."""
