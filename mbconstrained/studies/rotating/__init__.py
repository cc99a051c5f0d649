"""The study of a rotor over its speed: critical speeds, modes and their whirl, stability, unbalance response.

Read ``rotor_report`` (what is computed), then ``rotor_pictures``.
"""
