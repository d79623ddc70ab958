"""Inner loops: compiled where the installation found a C compiler, else in NumPy, with the same results to the byte.

Each module has a loop in both forms, which take and give the same arrays; `library` says which one runs.
"""
