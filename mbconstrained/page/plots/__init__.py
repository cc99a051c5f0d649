"""Plots over time and phase planes: axes, inline SVG for the page, the accuracy of displayed values, images for reports."""
