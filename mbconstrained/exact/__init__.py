"""The same questions with symbols."""
