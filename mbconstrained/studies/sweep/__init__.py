"""Sweeps, Monte Carlo and optimisation of a scene: many samples of its parameters, what comes of each, and statistics of all.

Read ``samples`` (which values), ``quantities`` (what is kept), ``evaluation`` (one chunk of samples), ``store`` and ``execution`` (where
chunks go and who computes them), ``sweep`` (the study), then ``statistics`` and ``sweep_report``; ``optimisation`` stands beside.
"""
