"""Sensitivities: derivatives with respect to parameters (``parameter``), of modes (``mode_derivatives``, ``sensitivities``) and of responses (``dual_system``)."""
