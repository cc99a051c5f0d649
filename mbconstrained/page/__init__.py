"""The page: what was solved, as one static HTML file with the model moving, plots and tables."""

from .content import Animation, Curve, PageContent, Plot, Table
from .drawing import Body, Drawing, Link
from .html import page_html
from .keyframes import KeyFrames, key_frames
from .write import write_page
