"""Closed forms as text, LaTeX, MathML, Python and C.

Read ``closed_form`` (the formula), ``terms`` and ``real_form`` (its terms, without complex roots), ``printing_layout``, then the
printers ``formula_text``, ``markup``, ``source_code`` and ``formula_data``; ``symbolic_equations`` has the models with symbols.
"""
