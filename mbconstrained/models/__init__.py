"""Ways to a mechanical system: lumped elements, matrices from files."""

from .lumped import LumpedModel

__all__ = ["LumpedModel"]
