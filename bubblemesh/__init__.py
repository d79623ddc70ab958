"""Triangle meshes by bubble packing."""

__version__ = "0.1.0"
