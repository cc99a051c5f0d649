"""Planning a scene and computing its motion. Read ``scene``, ``stages`` with ``plan``, then ``result``; ``drawing`` and ``animation`` are for
pages. The answer that users get is in ``analyses/run.py``."""
