"""A run: from a case to a mesh, a report and files."""
