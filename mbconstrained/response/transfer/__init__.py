"""Responses of transfer functions and of fractions of polynomial matrices (Hauksdottir and Sigurdsson)."""

from .closed_form import ClosedForm
from .matrix_fraction import matrix_fraction_response
from .transfer_function import TransferFunctionResponse, transfer_function_response

__all__ = ["ClosedForm", "TransferFunctionResponse", "matrix_fraction_response", "transfer_function_response"]
