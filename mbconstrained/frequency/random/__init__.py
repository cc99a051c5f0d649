"""Random excitation: spectra, covariance and spectral moments in closed form, statistics of extremes, sample paths.

Read ``spectra`` (one-sided power spectral densities, of several inputs), ``spectral_integral`` (the integrals of |H|^2 times a spectrum),
``random_response`` (the result), then ``nonstationary``.
"""
