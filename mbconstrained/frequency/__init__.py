"""Frequency responses: values with error estimates, poles, residues, polynomial part, peaks and antiresonances; arrays in, arrays out.

May import ``response`` and the rooms below it. Read ``frequency_response`` first (the class and the choice between the two methods), then
``harmonic`` (the matrices, and solutions of A(i w) X = B for many w), ``pole_residue_form`` (the sum of modes), ``features`` and ``plots``.
"""
