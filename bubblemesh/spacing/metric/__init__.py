"""Metrics: spacings that depend on the direction, as symmetric positive tensors (m11, m12, m22) at each place.

The length of an edge v in a metric M is sqrt(v M v); the spacing along a direction is what is 1 long there. The places
at a distance of 1 are an ellipse, whose axes are the least and the largest spacing.
"""
