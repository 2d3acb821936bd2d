"""Writes a drawing of SIDE x SIDE px in the ways that large drawings are kept, all black and white alike: FOLDER/
tiles.tif, strips.tif (BigTIFF, four channels of 16 bit), one.tif (a single strip, 8 bit), tiles.exr, lines.exr (four
channels of half), rows.png.

usage: large.py SIDE FOLDER [NAME ...]      (SIDE a multiple of 256)"""
import struct
import sys

import numpy as np
from PIL import Image

TILE = 256


def band(side, top, bottom):
    """Rings and bars, 1 where white."""
    y, x = np.mgrid[top:bottom, 0:side]
    return ((x // 53 + ((x - side // 2) ** 2 + (y - side // 3) ** 2) // 9001) & 1).astype(np.uint8)


def tiff(path, side, tile, rows, channels, bits):
    kind = np.uint16 if bits == 16 else np.uint8
    places, sizes = [], []

    def put(data):
        places.append(file.tell())
        file.write(data)
        sizes.append(len(data))

    with open(path, "wb") as file:
        file.write(b"II+\0" + struct.pack("<HHQ", 8, 0, 0))
        for top in range(0, side, rows if rows < side else TILE):
            white = band(side, top, top + (rows if rows < side else TILE)) * kind((1 << bits) - 1)
            pixels = np.repeat(white[:, :, None], channels, axis=2)
            pixels[:, :, 3:] = (1 << bits) - 1  # opaque
            if tile:
                for left in range(0, side, tile):
                    put(np.ascontiguousarray(pixels[:, left:left + tile]).tobytes())
            elif rows < side:
                put(pixels.tobytes())
            else:
                file.write(pixels.tobytes())
        if not places:
            places, sizes = [16], [file.tell() - 16]
        at = file.tell()
        file.write(np.array(places + sizes, "<u8").tobytes())
        start, lengths = (places[0], sizes[0]) if len(places) == 1 else (at, at + 8 * len(places))
        depth = sum(bits << 16 * i for i in range(channels))
        tags = [(256, 4, 1, side), (257, 4, 1, side), (258, 3, channels, depth), (259, 3, 1, 1),
                (262, 3, 1, 2 if channels > 2 else 1), (277, 3, 1, channels)]
        if channels == 4:
            tags += [(338, 3, 1, 2)]
        if tile:
            tags += [(322, 4, 1, tile), (323, 4, 1, tile), (324, 16, len(places), start), (325, 16, len(places), lengths)]
        else:
            tags += [(273, 16, len(places), start), (278, 4, 1, rows), (279, 16, len(places), lengths)]
        directory = file.tell()
        file.write(struct.pack("<Q", len(tags)))
        for tag in sorted(tags):
            file.write(struct.pack("<HHQQ", *tag))
        file.write(struct.pack("<Q", 0))
        file.seek(8)
        file.write(struct.pack("<Q", directory))


def exr(path, side, tile):
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1) for name in (b"A", b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, side - 1, side - 1)
    head = struct.pack("<II", 20000630, 0x202 if tile else 2)
    head += attribute(b"channels", b"chlist", channels) + attribute(b"compression", b"compression", b"\0")
    head += attribute(b"dataWindow", b"box2i", box) + attribute(b"displayWindow", b"box2i", box)
    head += attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    head += attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
    head += attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
    if tile:
        head += attribute(b"tiles", b"tiledesc", struct.pack("<IIB", tile, tile, 0))
    head += b"\0"
    count = (side // tile) ** 2 if tile else side
    size = 20 + 8 * tile * tile if tile else 8 + 8 * side
    one = np.float16(1)
    with open(path, "wb") as file:
        first = len(head) + 8 * count
        file.write(head + np.arange(first, first + size * count, size, dtype="<u8").tobytes())
        for top in range(0, side, TILE):
            white = band(side, top, top + TILE).astype("<f2")
            whole = np.stack([np.full_like(white, one), white, white, white], axis=1)  # rows of channels of pixels
            for row in [] if tile else range(TILE):
                file.write(struct.pack("<2i", top + row, 8 * side) + whole[row].tobytes())
            for left in range(0, side, tile) if tile else []:
                part = np.ascontiguousarray(whole[:, :, left:left + tile])
                file.write(struct.pack("<5i", left // tile, top // tile, 0, 0, 8 * tile * tile) + part.tobytes())


def png(path, side):
    Image.MAX_IMAGE_PIXELS = None
    white = np.concatenate([band(side, top, top + TILE) for top in range(0, side, TILE)])
    Image.fromarray(white * np.uint8(255)).save(path, compress_level=1)


def main():
    side, folder = int(sys.argv[1]), sys.argv[2]
    writers = {
        "tiles.tif": lambda path: tiff(path, side, TILE, TILE, 4, 16),
        "strips.tif": lambda path: tiff(path, side, 0, 64, 4, 16),
        "one.tif": lambda path: tiff(path, side, 0, side, 1, 8),
        "tiles.exr": lambda path: exr(path, side, TILE),
        "lines.exr": lambda path: exr(path, side, 0),
        "rows.png": lambda path: png(path, side),
    }
    for name in sys.argv[3:] or writers:
        writers[name](folder + "/" + name)


main()
