"""The project beside other mesh generators, in one run: ``python -m benchmarks.peers`` writes docs/peers.md."""
