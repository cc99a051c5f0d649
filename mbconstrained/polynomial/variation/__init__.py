"""A(s; p) over a parameter p: its eigenvalues with both vectors (``spectrum``), followed from value to value (``branches``)."""
