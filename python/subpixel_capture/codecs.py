"""Checksums and compression. CRC-32 and zlib are the standard library's; XXH3-64 and zstd, with which Subpixel itself
writes, come from whatever is there: the modules xxhash, zstandard and compression.zstd (Python 3.14), or the shared
libraries libxxhash and libzstd through ctypes. Where neither is, reading such a file is refused with that reason."""
import ctypes
import ctypes.util
import zlib

from .layout import CRC32


def crc32(*parts):
    value = 0
    for part in parts:
        value = zlib.crc32(part, value)
    return value & 0xFFFFFFFF


def _library(name, sonames):
    for soname in sonames:
        try:
            return ctypes.CDLL(soname)
        except OSError:
            pass
    found = ctypes.util.find_library(name)
    return ctypes.CDLL(found) if found else None


def _address(data):
    """A pointer to the bytes of `data` and the object that keeps them there."""
    held = bytes(data) if not isinstance(data, bytes) else data
    return ctypes.cast(ctypes.c_char_p(held), ctypes.c_void_p), held


_xxh3 = None


def _find_xxh3():
    try:
        import xxhash
        if hasattr(xxhash, "xxh3_64_intdigest"):
            return xxhash.xxh3_64_intdigest
    except ImportError:
        pass
    library = _library("xxhash", ("libxxhash.so.0", "libxxhash.0.dylib", "xxhash.dll"))
    if library is None or not hasattr(library, "XXH3_64bits"):
        return None
    library.XXH3_64bits.restype = ctypes.c_uint64
    library.XXH3_64bits.argtypes = [ctypes.c_void_p, ctypes.c_size_t]

    def digest(data):
        pointer, held = _address(data)
        return library.XXH3_64bits(pointer, len(held))

    return digest


def xxh3_64(*parts):
    """The checksum, or None where nothing here can compute it."""
    global _xxh3
    if _xxh3 is None:
        _xxh3 = _find_xxh3() or False
    return _xxh3(b"".join(bytes(part) for part in parts)) if _xxh3 else None


def checksum(kind, *parts):
    """Of the parts as if they were one, by the kind in a file's flags; None: not computable here."""
    return crc32(*parts) if kind == CRC32 else xxh3_64(*parts)


def inflate(stored, decoded_bytes):
    """The payload of one zlib stream. Raises ValueError with the reason; takes no more memory than decoded_bytes."""
    worker = zlib.decompressobj()
    try:
        payload = worker.decompress(bytes(stored), decoded_bytes + 1)
    except zlib.error as error:
        raise ValueError("zlib: {}".format(error))
    if len(payload) > decoded_bytes:
        raise ValueError("the payload decodes to more")
    if not worker.eof:
        # The last bytes of a stream may be its check alone: asked for again with nothing more allowed to come.
        try:
            payload += worker.decompress(worker.unconsumed_tail, 1)
        except zlib.error as error:
            raise ValueError("zlib: {}".format(error))
        if len(payload) > decoded_bytes:
            raise ValueError("the payload decodes to more")
        if not worker.eof:
            raise ValueError("zlib: the stream does not end")
    if worker.unused_data:
        raise ValueError("{} bytes follow the zlib stream".format(len(worker.unused_data)))
    if len(payload) != decoded_bytes:
        raise ValueError("the payload decodes to {} bytes".format(len(payload)))
    return payload


_zstd = None


def _zstd_library():
    library = _library("zstd", ("libzstd.so.1", "libzstd.1.dylib", "libzstd.dll", "zstd.dll"))
    if library is None:
        return None
    library.ZSTD_decompress.restype = ctypes.c_size_t
    library.ZSTD_decompress.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t]
    library.ZSTD_isError.argtypes = [ctypes.c_size_t]
    library.ZSTD_getErrorName.restype = ctypes.c_char_p
    library.ZSTD_getErrorName.argtypes = [ctypes.c_size_t]
    library.ZSTD_getFrameContentSize.restype = ctypes.c_uint64
    library.ZSTD_getFrameContentSize.argtypes = [ctypes.c_void_p, ctypes.c_size_t]

    def decompress(stored, decoded_bytes):
        pointer, held = _address(stored)
        if library.ZSTD_getFrameContentSize(pointer, len(held)) != decoded_bytes:
            raise ValueError("differs from the compressed payload's own size")
        out = ctypes.create_string_buffer(max(decoded_bytes, 1))
        got = library.ZSTD_decompress(out, decoded_bytes, pointer, len(held))
        if library.ZSTD_isError(got):
            raise ValueError("zstd: {}".format(library.ZSTD_getErrorName(got).decode("ascii", "replace")))
        if got != decoded_bytes:
            raise ValueError("the payload decodes to {} bytes".format(got))
        return ctypes.string_at(out, decoded_bytes)

    return decompress


def _zstd_module():
    try:
        from compression import zstd as module  # Python 3.14
        return module.decompress
    except ImportError:
        pass
    try:
        import zstandard
        return lambda stored: zstandard.ZstdDecompressor().decompress(stored)
    except ImportError:
        return None


def _find_zstd():
    decompress = _zstd_library()
    if decompress is not None:
        return decompress
    module = _zstd_module()
    if module is None:
        return None

    def by_module(stored, decoded_bytes):
        try:
            payload = module(bytes(stored))
        except Exception as error:
            raise ValueError("zstd: {}".format(error))
        if len(payload) != decoded_bytes:
            raise ValueError("the payload decodes to {} bytes".format(len(payload)))
        return payload

    return by_module


def unzstd(stored, decoded_bytes):
    """The payload of one zstd frame. Raises ValueError with the reason."""
    global _zstd
    if _zstd is None:
        _zstd = _find_zstd() or False
    if not _zstd:
        raise ValueError("compressed by zstd, and neither libzstd nor a Python module for it is installed here")
    return _zstd(stored, decoded_bytes)
