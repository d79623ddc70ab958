"""Arrangement of the lines of a domain: regions, interfaces, contacts; and tolerances for the same place."""

TOUCHING = 1e-9  # of the domain's size: nearer places are the same
NEARLY = 1e-6  # of the domain's size: nearer places that are not the same are a mistake of the user
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point
ROUNDINGS = 4  # rounding errors of coordinates far from the origin by which equal places may differ
