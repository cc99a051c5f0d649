"""Guaranteed values: the response of the data, taken as the exact numbers that they are, in intervals of any width."""

from .enclosure import Enclosure
from .exact_response import ExactResponse
from .problems import exact_fraction_response, exact_response, structure_notices
from .sources import Source, sources_of
