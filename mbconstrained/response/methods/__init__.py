"""Methods that evaluate a response, one file for each."""
