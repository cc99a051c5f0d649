"""Sweeps, Monte Carlo and optimisation of a scene: many samples of its parameters, their results, and statistics.

Read ``sampling`` (which values), ``kept_quantities`` (what is kept), ``evaluation`` (one chunk of samples), ``store`` and ``execution`` (where
chunks go and who computes them), ``sweep`` (the study), then ``sample_statistics`` and ``sweep_report``; ``optimisation`` is a study of its own.
"""
