"""What accuracy costs: the judges of each stage and their reports."""
