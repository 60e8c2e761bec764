"""Record what the page shows, for a folder that needs no server."""
