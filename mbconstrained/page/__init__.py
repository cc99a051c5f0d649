"""The page: a model with its motion, plots and tables as one static HTML file.

It draws lumped models, robots and coordinates; it imports the rooms of the mathematics, ``models`` and ``ground``, and no other
room that users see. Read ``drawing`` (bodies, links, paths), ``layout`` with ``automatic_drawing``, ``animation`` (key frames, swinging
shapes) and ``figure``, ``content`` (plots, tables), ``readings`` and ``plots``, and ``html``, which writes a page with its
scripts and security policy. ``assets`` has the scripts and the style sheet.
"""
