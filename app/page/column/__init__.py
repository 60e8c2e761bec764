"""Build the left column: question, prediction, knobs, tasks, exams and their dialogs."""
