"""From a case to a problem that is ready for packing: all binding and checking."""
