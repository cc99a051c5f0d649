"""Files of other programs: arrays in, arrays out; no mechanics and no scenes.

Read ``matrices`` (also columns of numbers in texts), ``samples`` (records over time); ``trajectories`` and ``universal`` write results.
"""
