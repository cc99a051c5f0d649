"""The stability study: correct and claimed digits for stiff and extreme systems, or for a scene scaled over decades."""
