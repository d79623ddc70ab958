"""How the lines of a domain meet: regions, interfaces, contacts."""
