"""Inner loops: compiled where the installation found a C compiler, else in NumPy, with the same results to the byte.

Each module has loops in both forms, which take and give the same arrays; `or_numpy` of `library` chooses between them,
so that no caller has to. The form in NumPy of loops over records of another room is there, with the same decorator.
"""
