#!/usr/bin/python3
"""Makes the images in this folder. Needs Debian's python3-pil and python3-numpy.

The picture is the same everywhere: 24 x 16 px, red grows to the right (x * 10), green grows down (y * 15), blue is 40.
"""
import os, struct, zlib
import numpy as np
from PIL import Image

os.chdir(os.path.dirname(os.path.abspath(__file__)))
W, H = 24, 16
x, y = np.meshgrid(np.arange(W), np.arange(H))
rgb = np.stack([x * 10, y * 15, 0 * x + 40], -1).astype(np.uint8)
alpha = ((x + y) * 6).astype(np.uint8)
rgba = np.dstack([rgb, alpha])
checker = ((x // 4 + y // 4) % 2).astype(bool)
picture, grey = Image.fromarray(rgb), Image.fromarray(rgb[..., 0].copy())

# The way back: what a camera stores so that orientation o shows the picture upright.
stored = {1: None, 2: Image.FLIP_LEFT_RIGHT, 3: Image.ROTATE_180, 4: Image.FLIP_TOP_BOTTOM, 5: Image.TRANSPOSE,
          6: Image.ROTATE_90, 7: Image.TRANSVERSE, 8: Image.ROTATE_270}
for o, how in stored.items():
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\1" + struct.pack(">HHIHHI", 274, 3, 1, o, 0, 0)
    (picture.transpose(how) if how is not None else picture).save(
        f"orientation-{o}.jpg", quality=100, subsampling=0, exif=exif)

Image.fromarray(checker).save("bilevel.png")
palette = Image.fromarray((x // 3 % 4).astype(np.uint8), "P")
palette.putpalette([255, 0, 0, 0, 255, 0, 0, 0, 255, 10, 20, 30])
palette.save("palette.png", bits=2)
palette.save("palette-alpha.png", bits=2, transparency=bytes([255, 128, 0, 255]))
Image.fromarray(rgba).save("rgba.png")
Image.merge("LA", (grey, Image.fromarray(alpha))).save("grey-alpha.png")
Image.fromarray((x * 2000 + y * 7).astype(np.uint16)).save("grey16.png")
exif = b"MM\0*\0\0\0\x08\0\1" + struct.pack(">HHIHHI", 274, 3, 1, 6, 0, 0) + b"\0\0\0\0"
picture.transpose(Image.ROTATE_90).save("orientation-6.png", exif=exif)
picture.save("rgb.webp", lossless=True)
Image.fromarray(rgba).save("rgba.webp", lossless=True, exact=True)
picture.save("rgb.ppm")
grey.save("grey.pgm")
Image.fromarray(~checker).save("bilevel.pbm")
open("ascii.pbm", "w").write("P1\n# by hand\n3 2\n1 0 1\n0 1 0\n")
open("ascii.pgm", "w").write("P2 3 2 10\n0 5 10\n10 5 0\n")
picture.save("rgb-lzw.tif", compression="tiff_lzw")
Image.fromarray(checker).save("bilevel-g4.tif", compression="group4")
picture.transpose(Image.ROTATE_90).save("orientation-6.tif", compression="tiff_adobe_deflate", tiffinfo={274: 6})


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(name, width, height, bits, colour, rows, interlace=0):
    with open(name, "wb") as f:
        head = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, interlace)
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head))
        f.write(chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


adam7 = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]
png("interlaced.png", W, H, 8, 2,
    b"".join(b"\0" + row.tobytes() for x0, y0, dx, dy in adam7 for row in rgb[y0::dy, x0::dx]), 1)
png("bomb.png", 60000, 60000, 8, 6, b"\0" * 16)
png("bad-filter.png", 4, 2, 8, 0, b"\0\1\2\3\4\7\1\2\3\4")
png("too-short.png", 4, 2, 8, 0, b"\0\1\2\3\4")
png("too-long.png", 4, 2, 8, 0, b"\0\1\2\3\4" * 3)


def tiff(name, order, tags, data, after=b""):
    """tags: (tag, type, values); data go behind the directory, at the offset given for tag 273 or 324."""
    size = {3: 2, 4: 4}
    pack = lambda t, v: struct.pack(order + {3: "H", 4: "I"}[t] * len(v), *v)
    at, extra, body = 8 + 2 + 12 * len(tags) + 4, b"", b""
    far = sum(len(v) * size[t] for _, t, v in tags if len(v) * size[t] > 4)
    for tag, t, v in tags:
        if tag in (273, 324):
            v = [at + far + o for o in v]
        raw = pack(t, v)
        if len(raw) > 4:
            body += struct.pack(order + "HHII", tag, t, len(v), at + len(extra))
            extra += raw
        else:
            body += struct.pack(order + "HHI", tag, t, len(v)) + raw.ljust(4, b"\0")
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "IH", 8, len(tags))
    open(name, "wb").write(head + body + b"\0\0\0\0" + extra + data)


premultiplied = np.dstack([np.round(rgb * (alpha[..., None] / 255.0)), alpha]).astype(np.uint8)
tiff("premultiplied.tif", "<", [(256, 4, [W]), (257, 4, [H]), (258, 3, [8] * 4), (259, 3, [1]), (262, 3, [2]),
     (273, 4, [0]), (277, 3, [4]), (278, 4, [H]), (279, 4, [W * H * 4]), (338, 3, [1])], premultiplied.tobytes())
floats = (rgb[..., 0] / 255.0).astype(">f4")
tiff("float-big-endian.tif", ">", [(256, 4, [W]), (257, 4, [H]), (258, 3, [32]), (259, 3, [1]), (262, 3, [1]),
     (273, 4, [0]), (277, 3, [1]), (278, 4, [H]), (279, 4, [W * H * 4]), (339, 3, [3])], floats.tobytes())
tiles = b"".join(np.pad(rgb, ((0, 0), (0, 8), (0, 0)))[:, i:i + 16].tobytes() for i in (0, 16))
tiff("tiled.tif", "<", [(256, 4, [W]), (257, 4, [H]), (258, 3, [8] * 3), (259, 3, [1]), (262, 3, [2]), (277, 3, [3]),
     (322, 4, [16]), (323, 4, [16]), (324, 4, [0, 768]), (325, 4, [768, 768])], tiles)


def exr(name, tiled, channels, origin=(0, 0), compression=0, short=0):
    """channels: name -> (kind, array), kind 0 uint, 1 half, 2 float."""
    kinds = {0: "<u4", 1: "<f2", 2: "<f4"}
    attribute = lambda n, t, v: n.encode() + b"\0" + t.encode() + b"\0" + struct.pack("<i", len(v)) + v
    names = sorted(channels)
    box = struct.pack("<4i", origin[0], origin[1], origin[0] + W - 1, origin[1] + H - 1)
    list_ = b"".join(n.encode() + b"\0" + struct.pack("<iBxxxii", channels[n][0], 0, 1, 1) for n in names) + b"\0"
    head = struct.pack("<ii", 20000630, 2 | (0x200 if tiled else 0)) + attribute("channels", "chlist", list_)
    head += attribute("compression", "compression", bytes([compression])) + attribute("dataWindow", "box2i", box)
    head += attribute("displayWindow", "box2i", box) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if tiled:
        head += attribute("tiles", "tiledesc", struct.pack("<IIB", 16, 16, 0))
    head += b"\0"

    def part(ys, xs):
        return b"".join(channels[n][1][yy, xs].astype(kinds[channels[n][0]]).tobytes() for yy in ys for n in names)

    def packed(raw):
        if compression == 0:
            return raw
        b = np.frombuffer(raw, np.uint8)
        b = np.concatenate([b[0::2], b[1::2]]).astype(int)
        b[1:] = (b[1:] - b[:-1] + 128) % 256
        b = b.astype(np.uint8).tobytes()
        return zlib.compress(b[:len(b) - short], 9)

    if tiled:
        chunks = [(struct.pack("<iiii", i // 16, j // 16, 0, 0),
                   packed(part(range(j, min(H, j + 16)), slice(i, min(W, i + 16)))))
                  for j in range(0, H, 16) for i in range(0, W, 16)]
    else:
        step = 16 if compression == 3 else 1
        chunks = [(struct.pack("<i", origin[1] + j), packed(part(range(j, min(H, j + step)), slice(0, W))))
                  for j in range(0, H, step)]
    offset, table, body = len(head) + 8 * len(chunks), b"", b""
    for where, data in chunks:
        table += struct.pack("<Q", offset + len(body))
        body += where + struct.pack("<i", len(data)) + data
    open(name, "wb").write(head + table + body)


light = rgb / 255.0
exr("tiled-half.exr", True, {"R": (1, light[..., 0]), "G": (1, light[..., 1]), "B": (1, light[..., 2])})
exr("window-zip.exr", False, {"R": (1, light[..., 0]), "G": (1, light[..., 1]), "B": (1, light[..., 2]),
                              "Z": (2, x * 1.0)}, (-7, 1000), 3)
exr("short-chunk.exr", False, {"Y": (2, light[..., 0])}, (0, 0), 3, 700)
exr("label-and-half.exr", False, {"Y": (1, light[..., 0]), "id": (0, x)})
