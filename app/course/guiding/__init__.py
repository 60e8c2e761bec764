"""Judge what is done in a scene, and draw its question."""
