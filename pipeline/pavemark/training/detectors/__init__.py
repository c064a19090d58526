"""Detectors of marking points and slots, trained on labelled images."""
