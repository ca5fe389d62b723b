"""Many trials of one scene, over what a sweep file varies."""
