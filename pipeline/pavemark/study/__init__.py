"""What synthetic images are worth to a detector: trained on them, judged on real ones of places it never saw."""
