"""The accuracy study: error against run time of the closed form and of other tools."""

from __future__ import annotations

__all__ = ["AccuracyReport", "accuracy_report"]
