"""Read the data of lessons from files, for the lessons of the course and for those of a folder."""
