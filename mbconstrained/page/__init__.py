"""The page: what was solved, as one static HTML file with the model moving, plots and tables."""

from .content import Animation, PageContent, Table
from .drawing import Body, Drawing, Link
from .html import page_html
from .keyframes import KeyFrames, key_frames
from .mode_content import ModePicture, ModesContent, cycle
from .modes_html import modes_html
from .parts import Part
from .path import Path
from .plot_content import Curve, PhasePlot, Plot
from .write import write_page
