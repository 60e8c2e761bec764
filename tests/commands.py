"""What the tests of the command line ask it with."""

from observer_lab.cli.entry import main


def refused(capsys, *words: str) -> str:
    """The one sentence on stderr of a command that must end with status 2 and print nothing else."""
    assert main(list(words)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    lines = err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("observer-lab: ") and lines[0].endswith(".")
    return lines[0]
