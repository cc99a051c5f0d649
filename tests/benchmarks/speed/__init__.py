"""Models, hand reductions, references and other methods of the tables of run times."""
