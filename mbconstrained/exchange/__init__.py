"""Files of other programs: arrays in, arrays out; no mechanics and no scenes.

Read ``number_table`` (text with columns of numbers), then ``samples`` (records over time), ``trajectories``, ``exported`` and
``universal``, which write results.
"""
