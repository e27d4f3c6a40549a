"""What tests of checkpoints share: the seal at a file's end, by an implementation of its own."""

import json

POLYNOMIAL = 0xC96C5795D7870F42  # ECMA-182, lowest bit first


def crc64(content):
    """Bit by bit, as the definition has it."""
    value = 2**64 - 1
    for byte in content:
        value ^= byte
        for _ in range(8):
            value = (value >> 1) ^ (POLYNOMIAL if value & 1 else 0)
    return value ^ (2**64 - 1)


assert crc64(b"123456789") == 0x995DC9BBDF1939FA  # as the catalogues of CRCs have it


def sealed(document):
    """Give a document as the file of a checkpoint, whose digest is right."""
    fields = {key: value for key, value in document.items() if key != "crc64"}
    text = json.dumps(fields, separators=(",", ":"))[:-1]
    return f'{text},"crc64":"{crc64(text.encode()):016x}"}}\n'
