"""Arrangement of the lines of a domain: regions, interfaces, contacts; and how near is the same."""

TOUCHING = 1e-9  # of the domain's size: nearer is the same
NEARLY = 1e-6  # of the domain's size: nearer, but not the same, is a slip of the user's
CONTACT_LENGTH = 1e5  # curves of radius R touch over a length of sqrt(8 R tolerance), not in a point
ROUNDINGS = 4  # of coordinates far from the origin, by which places that are meant to be one may differ
