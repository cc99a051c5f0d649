"""Scene files: read, validated, assembled, planned, run.

Read in the order in which data moves: ``file`` (text to tables, messages with places), ``quantities`` (units, parameters),
``schema`` (every table and key), ``build`` (the equations), ``run`` (plan, stages, result, reports, pictures);
``python_models`` gives motions that were computed in Python the same pages. A folder imports
only those before it; the room imports all rooms below it, of ``page`` only while a page or a drawing is made.
"""

from __future__ import annotations
