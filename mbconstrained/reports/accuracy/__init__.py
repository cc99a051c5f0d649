"""Error against run time: the closed form and what one would use instead."""

from .report import AccuracyReport, accuracy_report

__all__ = ["AccuracyReport", "accuracy_report"]
