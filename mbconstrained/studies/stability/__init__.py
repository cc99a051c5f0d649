"""The stability study: correct and claimed digits for stiff and extreme systems, or for a scene scaled over decades."""

from __future__ import annotations

__all__ = ["Point", "StabilityReport", "gallery_report", "point_of", "scene_report"]
