"""Reports of other questions than a run."""
