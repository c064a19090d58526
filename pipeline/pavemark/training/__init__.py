"""Networks of our own, trained on images of our own: needs the extra `train` (torch), nothing else does."""
