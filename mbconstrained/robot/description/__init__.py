"""The description of a robot as checked data: ``urdf`` (tree, masses, joints), ``masses`` (payloads, other masses), ``models`` (of
pinocchio) and ``visuals`` (shapes, meshes)."""
