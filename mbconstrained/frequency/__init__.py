"""Frequency responses, random vibration, shock and fatigue: values with error estimates, poles and residues, peaks; arrays in, arrays out.

May import ``response`` and the rooms below it. Read ``frequency_response`` first (the class and the choice between the two methods), then
``harmonic`` (the matrices, and solutions of A(i w) X = B for many w), ``pole_residue_form`` (the sum of modes), ``features`` and ``plots``; ``random`` has
a reading order of its own, ``extrema`` the peaks of functions of time, which ``shock_spectrum`` and ``fatigue`` ask for.
"""
