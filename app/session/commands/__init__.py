"""List what a person can ask of a tab, one frozen record each."""
