"""The pairs, values at 0- and a force become the response: a function of time, with its jumps and impulses."""

from __future__ import annotations

__all__ = [
    "Admissibility",
    "Event",
    "Response",
    "TransferFunctionResponse",
    "admissible",
    "matrix_fraction_response",
    "solve",
    "transfer_function_response",
]
