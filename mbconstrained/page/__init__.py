"""The page: a model with its motion, plots and tables as one static HTML file.

It draws lumped models, robots and coordinates; it imports the rooms of the mathematics, ``models`` and ``ground``, and no other
room that users see. Read ``drawing`` (bodies, links, paths and their layout), ``content`` (plots, tables, figures),
``animation`` (key frames, swinging shapes, figure data), ``plots``, ``sections`` and ``shape_sections`` (HTML), and ``html``, which writes
a page with its scripts and security policy. ``assets`` has the scripts and the style sheet.
"""
