"""Observer Lab: control what you cannot fully see."""
