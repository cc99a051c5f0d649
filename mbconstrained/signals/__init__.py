"""Functions of time with a closed form: Bohl functions, impulsive-smooth functions and inputs.

Imports ``ground`` and ``linalg``. Read ``bohl``, ``impulsive`` (with the exact descriptions that the room ``exact`` reads) and
``inputs``; then ``approximated`` for functions given by their values.
"""
