"""How accurate, and how fast? Reports that compare with what is known exactly and with other tools."""
