"""The accuracy study: error against run time of the closed form and of other tools."""
