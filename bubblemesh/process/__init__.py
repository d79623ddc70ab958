"""The process: the time and memory that a run may take, what it has taken, its cores, what its threads share."""
