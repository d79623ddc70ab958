"""Packing in a metric beside Mmg2D and BAMG."""
