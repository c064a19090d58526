"""Which synthetic images a detector should learn from."""
