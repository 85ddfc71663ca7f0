"""Text of others on a terminal: nothing in it is an order to the terminal, or to rich."""


def printable(text: str) -> str:
    """A text in which control characters and halves of characters are shown as what they are."""
    return "".join(
        character if character.isprintable() or character == "\n" else ascii(character)[1:-1]
        for character in text
    )


def one_line(text: str) -> str:
    """As `printable`, with line breaks shown as what they are too: the name of a file may hold them."""
    return printable(text).replace("\n", "\\n")
