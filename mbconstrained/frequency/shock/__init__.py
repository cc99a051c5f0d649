"""Shock: peaks of functions of time, and shock response spectra.

Read ``response_spectrum`` (the public function), then ``oscillator`` (records, exactly between their samples) and ``extrema`` (peaks of closed
forms).
"""
