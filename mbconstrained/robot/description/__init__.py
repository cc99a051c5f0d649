"""The description of a robot as checked data: ``urdf`` (tree, masses of links, payloads, SRDF), ``extensions`` and ``sdf``, ``mjcf``, and
``meshes`` (files of shapes)."""
