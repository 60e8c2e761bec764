"""Write the guide as a folder of files that needs no server."""
