"""Write a design as a Python, MATLAB or notebook script that checks itself."""
