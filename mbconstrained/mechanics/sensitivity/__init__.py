"""Sensitivities: derivatives with respect to parameters (``parameter``), of modes (``mode_derivatives``) and of responses (``sensitivities``)."""
