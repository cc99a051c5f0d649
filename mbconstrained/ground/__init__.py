"""The base of all rooms: errors, notices, validation, tolerances, files, units of coordinates, threads.

Imports nothing of the package. Read ``errors``, ``notices``, ``checks`` and ``tolerances``; ``coordinate_units``, ``files`` and
``threads`` serve single purposes.
"""
