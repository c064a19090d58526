"""The one error a user is meant to see."""


class InputError(Exception):
    """Bad input, told in one line.

    Parameters
    ----------
    where : str
        The file (or command-line option) that holds the bad value.
    what : str
        The field, the value found and what is allowed.
    """

    def __init__(self, where: object, what: str) -> None:
        super().__init__(f"{where}: {what}")
        self.where = str(where)
        self.what = what

    def __reduce__(self) -> tuple:
        # A process of a pool that is refused something tells it to the one that started it.
        return InputError, (self.where, self.what)


def one_line(text: str) -> str:
    """Text as a terminal may safely be told: what is not printable, as in a hostile file name, is spelled out."""
    return "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in text)
