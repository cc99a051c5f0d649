"""Speed beside what one would use instead: models, hand reductions, references, peers, measuring and the report."""
