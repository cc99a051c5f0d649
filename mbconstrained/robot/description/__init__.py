"""The description of a robot as checked data: ``urdf`` (tree, masses, joints) and ``visuals`` (shapes, meshes)."""
