"""Sweeps, Monte Carlo and optimisation of a scene: many samples of its parameters, their results, and statistics.

Read ``samples`` (which values, and statistics), ``kept_quantities`` (what is kept), ``evaluation`` (one chunk of samples), ``store`` and
``execution`` (where chunks go and who computes them), ``sweep`` (the study and its result), then ``plots``; ``optimisation`` is a study of its own.
"""
