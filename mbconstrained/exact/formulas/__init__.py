"""The formula of an answer as text, LaTeX, MathML, Python and C."""

from .c_source import c_source
from .closed_form import ClosedForm, Impulse, Jump, Parameter
from .latex import latex
from .mathml import mathml
from .plain_text import plain_text
from .python_source import python_source

__all__ = ["ClosedForm", "Impulse", "Jump", "Parameter", "c_source", "latex", "mathml", "plain_text", "python_source"]
