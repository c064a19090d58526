"""The program `pavemark`. Its libraries take a second to load; who interrupts that is told nothing of Python."""

import sys


def main() -> None:
    """Run the command line."""
    try:
        from pavemark import cli  # noqa: PLC0415 - inside the try
    except KeyboardInterrupt:
        sys.exit(130)
    cli.main()


if __name__ == "__main__":
    main()
