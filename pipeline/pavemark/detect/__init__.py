"""Detectors of parking slots, and the labelled images that they learn from and are judged by."""
