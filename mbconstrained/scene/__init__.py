"""Scene files: read, validated, assembled, planned, solved.

Read in the order in which data moves: ``file`` (text to tables, values of the command line, messages with places), ``parameters``,
``coordinates`` (their values with units), ``variations``, ``schema`` (every table and key), ``build`` (the model: ``model`` has its
interface, ``equations`` assembles it), ``run`` (plan, stages, motion, pictures). Each imports only those before it; the room imports all
rooms below it, of ``page`` only while a page or a drawing is made.
"""

from __future__ import annotations
