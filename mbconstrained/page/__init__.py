"""The page: what was solved, as one static HTML file with the model moving, plots and tables."""

from .content import Animation, Curve, PageContent, Plot, Table
from .drawing import Body, Drawing, Link
from .html import page_html
from .keyframes import KeyFrames, key_frames
from .mode_content import ModePicture, ModesContent, cycle
from .modes_html import modes_html
from .parts import Part
from .path import Path
from .write import write_page
