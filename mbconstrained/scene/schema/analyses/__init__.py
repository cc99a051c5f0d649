"""The tables of a scene for analyses in addition to its run: [frequency], [random], [shock], [vary], [campbell], [path]."""
