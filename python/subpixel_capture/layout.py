"""The bytes of SPEC.md that reader and writer share."""
import struct

MAGIC = b"\x89SPCAP\n\x1a"
END_MAGIC = b"SPCAPEND"
XXH3, CRC32 = 0, 1          # the file header's flags
STORED, ZSTD, ZLIB = 0, 1, 2  # codecs
MOST_INFLATION = 1032       # bytes that deflate can make of one

HEADER = struct.Struct("<8sII")          # magic, version, flags
CHUNK = struct.Struct("<4sIIIQQ")        # type, id, codec, reserved, stored_bytes, decoded_bytes; a checksum follows
CHUNK_BYTES = 40
INDEX_ENTRY = struct.Struct("<4sIQ")     # type, id, offset
FOOTER = struct.Struct("<QQQ8s")         # index_offset, file_bytes, checksum, end magic

ORDER = (b"META", b"DATA", b"BUFR", b"TEXR", b"MATL", b"FRAM", b"INDX")

MOST_TEXT_BYTES = 65536
MOST_NOTICES = 4096
MOST_SIDE = 16384
MOST_OF = {"buffers": 1 << 20, "textures": 65536, "materials": 65536, "frames": 65536}
MOST_DRAWS, MOST_LIGHTS, MOST_TRIANGLES = 1 << 20, 65536, 1 << 28
MOST_BYTES = 8 << 30

FORMATS_OF = {1: 8, 2: 10, 3: 17}  # vertex formats of a version: those below this


def aligned(offset):
    return (offset + 7) // 8 * 8


def record_struct(letters):
    return struct.Struct("<" + letters)
