"""Planning a scene and computing its motion. Read ``scene``, ``stages`` with ``plan``, then ``result``; ``picture`` has the drawing and the
animation, ``modes`` the modes without a motion. The answer that users get is in ``analyses/run.py``."""
