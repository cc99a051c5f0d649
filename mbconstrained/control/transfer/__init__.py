"""Responses of transfer functions b(s)/a(s) and of fractions of polynomial matrices (Hauksdottir and Sigurdsson).

Read in this order: rational (exact polynomials), matrix_fraction, early_response, transfer_function.
"""
