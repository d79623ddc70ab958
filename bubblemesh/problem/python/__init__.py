"""What Python programs give to `bubblemesh.mesh`, checked: errors name its arguments."""
