"""Population control: which bubbles go, and where new ones come."""
