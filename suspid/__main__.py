"""``python -m suspid`` is ``suspid``."""

from suspid.cli import main

if __name__ == "__main__":
    main(prog_name="suspid")
