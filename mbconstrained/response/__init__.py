"""The pairs, values at 0- and a force become the response: a function of time, with its jumps and impulses."""

from .admissible import Admissibility, admissible
from .events import Event
from .response import Response
from .solve import solve
from .transfer import TransferFunctionResponse, matrix_fraction_response, transfer_function_response

__all__ = ["Admissibility", "Event", "Response", "TransferFunctionResponse", "admissible", "matrix_fraction_response", "solve", "transfer_function_response"]
