"""Arguments of Python programs for `bubblemesh.mesh`, checked: errors name them."""
