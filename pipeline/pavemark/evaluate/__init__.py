"""How good a detector is: matching (Eq. 3), precision and recall, their intervals, ensembles."""
