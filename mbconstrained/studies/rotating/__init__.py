"""Eigenvalues over a speed or a parameter: Campbell diagrams with the unbalance response of a rotor, and root loci.

Read ``rotor_report`` (what is computed), then ``rotor_pictures``; ``locus_report`` has root loci.
"""
