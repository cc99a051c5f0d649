"""Stiff and extreme systems: how many digits are right, how many were claimed, and whether a warning came."""

from .point import Point, point_of
from .report import StabilityReport, gallery_report, scene_report

__all__ = ["Point", "StabilityReport", "gallery_report", "point_of", "scene_report"]
