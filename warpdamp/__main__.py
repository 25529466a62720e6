"""``python -m warpdamp``."""

from .cli.app import app

if __name__ == "__main__":
    app(prog_name="warpdamp")
