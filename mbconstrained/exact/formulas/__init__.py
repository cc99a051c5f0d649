"""Closed forms as text, LaTeX, MathML, Python and C.

Read ``closed_form`` (the formula), ``printing_layout`` (its terms), ``real_form`` (without complex roots), then the printers
``formula_text``, ``markup`` and ``source_code``; ``symbolic_equations`` has the models with symbols.
"""
