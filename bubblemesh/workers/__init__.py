"""Worker processes, on this machine or on a cluster, for the cases of a batch and the parts of a mesh."""
