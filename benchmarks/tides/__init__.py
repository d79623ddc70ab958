"""Tides in a drawn archipelago: from a shore in degrees to a model that runs, with its books in balance."""
