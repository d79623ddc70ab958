"""One mesh of many parts: the domain is cut, its parts are packed side by side and joined, and the seams smoothed."""
