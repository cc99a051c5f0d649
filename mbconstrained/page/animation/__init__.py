"""Animations: the motion of a drawing with forces, jumps and impulses, its key frames, and the data of the page's script."""
