"""e^{J t} v for a block diagonal J, at any times and at even steps.

Read ``oscillations`` (pairs a +- i w), ``clusters`` (multiple and close eigenvalues) and ``block_exponential`` (all blocks) first;
``powers`` (e^{S t} without modes), ``recursion`` and ``stepping`` (from time to time under a record) serve single methods of
``response``.
"""
