"""Planning and running a scene. Read ``scene``, ``stages`` with ``decisions``, then ``result``; ``report`` has its tables and texts,
``picture`` its drawing, ``modes`` the modes without a motion."""
