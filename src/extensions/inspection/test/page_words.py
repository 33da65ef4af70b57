"""The text of a page, without its scripts and styles."""

from html.parser import HTMLParser


class _Words(HTMLParser):
    def __init__(self):
        super().__init__()
        self.text, self._skip = [], False

    def handle_starttag(self, tag, attrs):
        self._skip = tag in ("script", "style")

    def handle_endtag(self, tag):
        self._skip = False

    def handle_data(self, data):
        self.text += [] if self._skip else data.split()


def words(path):
    """Return the words of a page, with one space between."""
    parser = _Words()
    parser.feed(path.read_text(encoding="utf-8"))
    return " ".join(parser.text)
