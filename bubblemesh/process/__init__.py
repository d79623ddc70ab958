"""The process: the time and the memory that a run may take, what it has taken, and the cores it may use."""
