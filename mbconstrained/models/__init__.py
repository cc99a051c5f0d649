"""Ways to a system: lumped elements, matrices from files, state spaces of control engineering."""

from .lumped import LumpedModel
from .state_space import StateSpace
from .state_space_response import StateSpaceResponse

__all__ = ["LumpedModel", "StateSpace", "StateSpaceResponse"]
