"""The sea in a box: land cut out of it, what is too narrow, the detail of its shore, its rings."""
