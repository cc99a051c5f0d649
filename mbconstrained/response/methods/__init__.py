"""One file for each method that evaluates a response."""
