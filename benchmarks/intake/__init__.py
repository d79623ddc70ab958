"""Files with geometry as users have them: which get in at once, which with the key that the message names."""
