"""The formulas of the papers as they stand there, corrected: views for study and comparison."""
