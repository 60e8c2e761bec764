"""Hold the words of the frame around every lesson and turn Markdown into MathML."""
