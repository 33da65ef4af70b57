"""The thesis's chapter 8 reproduced in one call, and written down beside the thesis's own figures."""
