"""`python -m billow`: the command, where its script is not on the path."""

from billow.cli.main import main

if __name__ == "__main__":
    main()
