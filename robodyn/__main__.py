"""`python -m robodyn`: the command line, also from a checkout that is not installed."""

from robodyn.cli.start import start

if __name__ == "__main__":
    start()
