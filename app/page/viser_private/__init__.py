"""Touch what is private in viser, in one place, and run our scripts in its page."""
