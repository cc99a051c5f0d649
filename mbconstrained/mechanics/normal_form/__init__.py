"""Transformation of first-order state-space systems into second-order, mechanical ones (Mayet and Kammermeier, corrected).

Read in this order: descriptor (validation and scaling), existence, extension, normal_form; the paper's own methods are in ``papers.normal_form_rows``.
"""
