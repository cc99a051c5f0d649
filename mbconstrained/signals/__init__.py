"""Functions of time with a closed form: Bohl functions, impulsive-smooth functions and inputs.

Imports ``ground`` and ``linalg``. Read ``bohl`` (with ``restarts``, on which it rests), ``impulsive`` and ``inputs``; then
``approximated`` for functions given by their values, and ``exact_inputs``, the descriptions that the room ``exact`` reads.
"""
