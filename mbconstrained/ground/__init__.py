"""The base of all rooms: errors, notices, validation, tolerances, files, units, threads.

Imports nothing of the package. Read ``errors``, ``notices``, ``checks`` and ``tolerances``; ``units``, ``files`` and ``threads``
serve single purposes.
"""
