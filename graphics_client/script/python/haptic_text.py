"""Text that another party wrote, for terminals and logs."""
import re

# C0 and C1 controls, DEL, line separators, what turns the direction of writing, and halves of characters.
UNSAFE = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text, longest=2000):
    """`text` with such characters escaped, as \\x1b and \\u202e; beyond `longest` characters it ends with "..."."""
    shown = text if len(text) <= longest else text[:longest] + "..."
    return UNSAFE.sub(lambda found: f"\\x{ord(found[0]):02x}" if found[0] <= "\xff" else f"\\u{ord(found[0]):04x}", shown)
