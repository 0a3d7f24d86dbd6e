# SPDX-License-Identifier: MIT
"""Measured surfaces: pictures and arrays with a spacing of their own."""
import struct
import zlib

import dermis
import numpy as np
import pytest
from PIL import Image

PERIOD, SIDE, RELIEF = 0.46e-3, 8e-3, 6e-5
AT_REST = {"fields": [{"at": 0, "what": ["deformation", "curvature"]}]}


def ridges(x, y):
    """Heights from 0 to 1 of curved ridges, x and y in m."""
    return 0.5 + 0.5 * np.sin(2 * np.pi / PERIOD * np.hypot(x + 1e-3, y - 12e-3))


def ridges_curvature(x, y):
    """Their Laplacian, 1/m2, in closed form: f'' + f'/r of a function of the radius."""
    r, k = np.hypot(x + 1e-3, y - 12e-3), 2 * np.pi / PERIOD
    return 0.5 * (-k * k * np.sin(k * r) + k * np.cos(k * r) / r)


def places(spacing, side=SIDE):
    at = (np.arange(round(side / spacing)) + 0.5) * spacing
    return np.meshgrid(at, at)


def scene(cell, path, **surface):
    cells = round(SIDE / cell)
    return dermis.fingertip(grid={"width": cells, "height": cells, "spacing": cell},
                            surface={"kind": "file", "path": path, "relief": RELIEF, **surface},
                            load={"intensity": "20 kPa"}, time={"step": "10 ms", "duration": 0.05},
                            output=AT_REST)


def at_rest(scene):
    """The surface and its curvature, of a scene that has them as fields at 0."""
    fields = dermis.run(scene).fields
    return fields["deformation", 0], fields["curvature", 0]


def loss(map, truth):
    """The share of the rms that is lost, a few cells from the border, where nobody knows how a surface goes on."""
    inner = (slice(4, -4), slice(4, -4))
    return 1 - np.sqrt(np.mean(map[inner] ** 2) / np.mean(truth[inner] ** 2))


@pytest.mark.parametrize("spacing", [20e-6, 50e-6])  # 50 um is 508 dpi
@pytest.mark.parametrize("cell", [50e-6, 100e-6, 200e-6])
def test_a_surface_with_its_own_spacing_keeps_its_curvature_on_coarse_cells(spacing, cell):
    surface, curvature = at_rest(scene(cell, ridges(*places(spacing, SIDE + 2e-4)), spacing=spacing))
    truth = RELIEF * ridges_curvature(*places(cell))
    assert abs(loss(curvature, truth)) < 0.01
    inner = (slice(4, -4), slice(4, -4))
    difference = surface - RELIEF * ridges(*places(cell))
    assert np.abs(difference[inner]).max() < 0.01 * RELIEF
    _, on_cells = at_rest(scene(cell, ridges(*places(cell))))
    assert loss(on_cells, truth) > {50e-6: 0.02, 100e-6: 0.09, 200e-6: 0.3}[cell]


@pytest.mark.parametrize("bits", [8, 16])
def test_a_picture_is_heights_from_black_to_white_with_its_top_row_first(tmp_path, bits):
    most, kind = 2**bits - 1, {8: np.uint8, 16: np.uint16}[bits]
    grey = np.arange(12 * 9).reshape(9, 12).astype(kind) * (most // 107)
    grey[0, 0], grey[8, 11] = 0, most
    Image.fromarray(grey).save(tmp_path / "print.png")
    tables = {"grid": {"width": 12, "height": 9}}
    light, dark = (dermis.Scene(tables, surface={"kind": "file", "path": tmp_path / "print.png", "high": high})
                   for high in ("white", "black"))
    np.testing.assert_array_equal(light.surface.path, grey / most)
    np.testing.assert_array_equal(dark.surface.path, 1 - grey / most)
    assert light == dermis.Scene(tables, surface={"path": grey / most})


@pytest.mark.parametrize("kind", ["<f8", ">f8", "<f4", ">f4", "<f2", ">f2", "|i1", "<i2", ">i2", "<i4", "<i8", ">i8",
                                  "|u1", "<u2", ">u2", ">u4", "<u8", "|b1"])
def test_a_file_may_hold_numbers_of_any_type(tmp_path, kind):
    numbers = np.random.default_rng(1).integers(0, 100, (9, 12)).astype(kind)
    np.save(tmp_path / "map.npy", numbers)
    tables = {"grid": {"width": 12, "height": 9}}
    for path in (tmp_path / "map.npy", numbers):
        surface = dermis.Scene(tables, surface={"kind": "file", "path": path}).surface
        np.testing.assert_array_equal(surface.path, numbers.astype(float))


def test_half_floats_of_every_size_are_read(tmp_path):
    numbers = np.arange(0, 0x7C00, 5, dtype=np.uint16)  # bit patterns of all that is finite and not negative
    numbers = np.concatenate([numbers, numbers | 0x8000])[:124 * 102].view(np.float16).reshape(124, -1)
    np.save(tmp_path / "map.npy", numbers)
    tables = {"grid": {"width": numbers.shape[1], "height": 124}}
    surface = dermis.Scene(tables, surface={"kind": "file", "path": tmp_path / "map.npy"}).surface
    np.testing.assert_array_equal(surface.path, numbers.astype(float))


def test_heights_in_metres_beside_the_relief_of_a_preset_are_refused():
    heights = RELIEF * ridges(*places(1e-4))
    grid = {"width": 80, "height": 80, "spacing": 1e-4}
    with pytest.raises(dermis.Error, match=r"surface.relief = \(not given\); allowed: 1 for heights in metres: these"):
        dermis.fingertip(grid=grid, surface={"path": heights})
    for relief in (1, 5e-5):
        surface, _ = at_rest(dermis.fingertip(grid=grid, surface={"path": heights, "relief": relief}, output=AT_REST))
        np.testing.assert_allclose(surface, relief * heights)
    dermis.fingertip(grid=grid, surface={"path": heights / RELIEF})  # from 0 to 1


def test_the_period_of_measured_ridges_is_known_and_coarse_cells_are_warned_of():
    for cell, within in ((50e-6, True), (100e-6, False)):
        figure = dermis.run(scene(cell, ridges(*places(cell)))).report().cells_per_ridge
        assert figure.value * cell == pytest.approx(PERIOD, rel=0.02) and (figure.value >= figure.least) == within
    fine = dermis.run(scene(100e-6, ridges(*places(20e-6)), spacing=20e-6)).report().cells_per_ridge
    assert fine.value == np.inf  # the curvature is not computed on these cells
    crests = dict(load={"kind": "circular", "contact": "crests", "intensity": "20 kPa"})
    dermis.run(dermis.fingertip(grid={"width": 80, "height": 80, "spacing": 1e-4}, **crests,
                                surface={"path": ridges(*places(20e-6)), "spacing": 20e-6}))  # knows contact_length


def test_rough_surfaces_have_no_period():
    random = np.random.default_rng(7)
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(80), np.fft.fftfreq(80)))
    frequency[0, 0] = 1
    for slope in [0, 1, 1.5, 2] * 5:
        waves = np.fft.fft2(random.standard_normal((80, 80))) / frequency**slope
        rough = np.fft.ifft2(waves).real
        result = dermis.run(scene(1e-4, rough / np.ptp(rough)))
        assert result.report().cells_per_ridge.value == np.inf


def test_a_measured_surface_has_the_same_bits_on_vulkan():
    measured = scene(1e-4, ridges(*places(50e-6)), spacing=50e-6)
    result = dermis.run(measured, precision="f32", check=True)
    assert result.model == "march" and result.cells_compared > 0 and result.cells_different == 0


def test_a_skin_at_rest_has_the_measured_curvature():
    measured = scene(2e-4, ridges(*places(20e-6)), spacing=20e-6)
    skin = dermis.Skin(measured)
    skin.press(np.zeros((40, 40), np.float32), 1e-3)
    np.testing.assert_array_equal(skin["curvature"], at_rest(measured)[1].astype(np.float32))


@pytest.mark.parametrize("surface, says", [
    ({"spacing": 5e-5}, r"surface.spacing = 5e-05; allowed: a spacing with which the file covers the grid: it has 80 x "
                        r"80 numbers, the grid 80 x 80 cells of 1e-04 m"),
    ({"spacing": 0}, "surface.spacing = 0; allowed: a finite number > 0"),
])
def test_a_spacing_that_cannot_be_is_refused(surface, says):
    with pytest.raises(dermis.Error, match=says):
        scene(1e-4, np.zeros((80, 80)), **surface)


def test_what_has_no_spacing_is_refused_by_name(tmp_path):
    for tables in ({"surface": {"kind": "wave", "spacing": 1e-4}, "grid": {"spacing": 1e-4}},
                   {"surface": {"path": np.zeros((150, 150)), "spacing": 1}}):
        allowed = 'surface.spacing = .*; allowed: only with kind = "file" and grid.spacing'
        with pytest.raises(dermis.Error, match=allowed):
            dermis.Scene(tables)
    with pytest.raises(dermis.Error, match="surface.curvature = .given.; allowed: none with the published stencil"):
        dermis.fingertip(grid={"width": 80, "height": 80, "spacing": 1e-4}, curvature={"stencil": "published"},
                         surface={"path": np.zeros((80, 80)), "spacing": 1e-4})
    (tmp_path / "cut.png").write_bytes(b"\x89PNG\r\n\x1a\n and no more")
    with pytest.raises(dermis.Error, match=r"surface.path = .*cut.png\": cannot be read \(.*\); allowed: a PNG of"):
        scene(1e-4, tmp_path / "cut.png")
    Image.fromarray(np.zeros((3, 4), np.uint8)).save(tmp_path / "small.png")
    with pytest.raises(dermis.Error, match="small.png\": has 4 x 3 pixels; allowed: a PNG of 80 x 80 opaque pixels"):
        scene(1e-4, tmp_path / "small.png")


def flat(path, **keys):
    scene = dermis.Scene(grid={"width": 5, "height": 4}, surface={"kind": "file", "path": path, **keys})
    return scene.surface.path


GREY = np.arange(20, dtype=np.uint8).reshape(4, 5) * 12


@pytest.mark.parametrize("table, path", [("surface", "surface"), ("load", "load"), ("load", "load.texture")])
def test_which_grey_of_a_picture_is_high_is_asked_for(tmp_path, table, path):
    Image.fromarray(GREY).save(tmp_path / "print.png")
    np.save(tmp_path / "print.npy", GREY)
    def read(name, **high):
        inner = {"path": tmp_path / name, **high}
        keys = {"texture": inner} if path.endswith("texture") else {"kind": "file", **inner}
        return dermis.Scene(grid={"width": 5, "height": 4}, **{table: keys})
    with pytest.raises(dermis.Error, match=rf'{path}.high = \(not given\); allowed: high = "white" or high = "black"'):
        read("print.png")
    with pytest.raises(dermis.Error, match=f'{path}.high = .grey.; allowed: "black", "white"'):
        read("print.png", high="grey")
    with pytest.raises(dermis.Error, match=f"{path}.high = .white.; allowed: only where path is a picture, a PNG"):
        read("print.npy", high="white")
    if path == "load":
        white, black = (read("print.png", high=high).load.path for high in ("white", "black"))
        np.testing.assert_array_equal(white, GREY / 255)
        np.testing.assert_array_equal(black, 1 - GREY / 255)


def test_a_texture_is_an_array_or_a_file_and_a_list_is_refused_by_its_beginning(tmp_path):
    numbers = np.random.default_rng(2).random((30, 40))
    np.save(tmp_path / "texture.npy", numbers)

    def run(path):
        texture = {"path": path, "spacing": 1e-4, "velocity": [0.01, 0.003]}
        return dermis.run(dermis.fingertip(grid={"width": 20, "height": 20, "spacing": 1e-4}, load={"texture": texture},
                                           time={"step": "1 ms", "duration": 0.02}))["sa1"].mean

    np.testing.assert_array_equal(run(numbers), run(tmp_path / "texture.npy"))
    with pytest.raises(dermis.Error, match=r"^load.texture.path = .*; allowed: a text in quotes$") as refused:
        run(numbers.tolist())
    assert len(str(refused.value)) < 300


def test_the_picture_of_a_material_is_refused(tmp_path):
    Image.fromarray(GREY).save(tmp_path / "map.png")
    with pytest.raises(dermis.Error, match="material.modulus = .*map.png.; allowed: a number, or a .npy file of numbers"):
        dermis.Scene(grid={"width": 5, "height": 4}, material={"modulus": str(tmp_path / "map.png"), "viscosity": 1})


@pytest.mark.parametrize("mode", ["LA", "RGBA", "RGB", "1", "P"])
def test_opaque_pictures_of_any_kind_are_read(tmp_path, mode):
    grey = (GREY > 100) * np.uint8(255) if mode == "1" else GREY
    Image.fromarray(grey).convert(mode).save(tmp_path / "print.png")
    np.testing.assert_array_equal(flat(tmp_path / "print.png", high="white"), grey / 255)


def test_colours_have_the_weights_of_stb(tmp_path):
    colours = np.random.default_rng(4).integers(0, 256, (4, 5, 3), np.uint8)
    Image.fromarray(colours).save(tmp_path / "print.png")
    grey = (colours.astype(int) @ [77, 150, 29]) >> 8
    np.testing.assert_array_equal(flat(tmp_path / "print.png", high="white"), grey / 255)


@pytest.mark.parametrize("mode", ["LA", "RGBA", "L", "RGB", "P"])
def test_a_transparent_pixel_is_refused_by_its_place(tmp_path, mode):
    picture = Image.fromarray(GREY).convert(mode)
    if mode.endswith("A"):
        picture.putpixel((3, 2), (7,) * (len(mode) - 1) + (254,))
        picture.save(tmp_path / "print.png")
    else:  # a colour that counts as transparent
        clear = picture.getpixel((3, 2))
        picture.save(tmp_path / "print.png", transparency=clear)
    with pytest.raises(dermis.Error, match=r"print.png\": is transparent.* at pixel \[3, 2\]; allowed: .* opaque pixels"):
        flat(tmp_path / "print.png", high="white")


@pytest.mark.parametrize("kind", ["BMP", "TIFF", "JPEG", "GIF", "PPM", "WEBP"])
def test_pictures_of_other_kinds_are_named_and_a_png_is_asked_for(tmp_path, kind):
    Image.fromarray(GREY).save(tmp_path / "print", format=kind)
    name = "file of another kind" if kind in ("PPM", "WEBP") else kind
    with pytest.raises(dermis.Error, match=f'surface.path = .*print", a {name}; allowed: a .npy file of numbers, or a PNG:'):
        flat(tmp_path / "print", high="white")


def chunk(name, data):
    return len(data).to_bytes(4, "big") + name + data + zlib.crc32(name + data).to_bytes(4, "big")


def indexed(numbers, palette, *more):
    """A PNG of eight bits whose pixels are numbers in a palette, with more chunks behind it."""
    header = struct.pack(">IIBBBBB", numbers.shape[1], numbers.shape[0], 8, 3, 0, 0, 0)
    rows = b"".join(b"\0" + row.tobytes() for row in numbers)
    chunks = [(b"IHDR", header), (b"PLTE", palette), *more, (b"IDAT", zlib.compress(rows)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*one) for one in chunks)


@pytest.mark.parametrize("colours", [9, 200, 256])
def test_a_number_beyond_a_palette_is_refused_by_its_place(tmp_path, colours):
    path, numbers = tmp_path / "print.png", (np.arange(20).reshape(4, 5) % colours).astype(np.uint8)
    palette = np.repeat(np.arange(colours, dtype=np.uint8)[::-1], 3).tobytes()
    for more in ([], [(b"tRNS", b"\xff" * colours)]):
        path.write_bytes(indexed(numbers, palette, *more))
        np.testing.assert_array_equal(flat(path, high="white"), (colours - 1 - numbers) / 255)
    if colours == 256:
        return
    numbers[2, 3] = colours
    says = r"print.png\": is transparent, or has a colour that its palette lacks, at pixel \[3, 2\]; allowed"
    for more in ([], [(b"tRNS", b"\xff" * colours)]):
        path.write_bytes(indexed(numbers, palette, *more))
        with pytest.raises(dermis.Error, match=says):
            flat(path, high="white")
    path.write_bytes(indexed(numbers, palette, (b"tRNS", b"\xff" * (colours + 1))))
    with pytest.raises(dermis.Error, match="is damaged in its chunk tRNS"):
        flat(path, high="white")


@pytest.mark.parametrize("damage, says", [("pixel", "is damaged in its chunk IDAT"), ("end", "ends before its last chunk")])
def test_a_damaged_picture_is_refused_by_how_it_is_damaged(tmp_path, damage, says):
    Image.fromarray(GREY).save(tmp_path / "print.png")
    png = bytearray((tmp_path / "print.png").read_bytes())
    if damage == "pixel":
        png[png.index(b"IDAT") + 6] ^= 1
    else:
        del png[-12:]
    (tmp_path / "print.png").write_bytes(png)
    with pytest.raises(dermis.Error, match=says):
        flat(tmp_path / "print.png", high="white")


def test_a_picture_of_more_than_268_mb_is_refused_by_its_header(tmp_path):
    header = struct.pack(">IIBBBBB", 8192, 8192, 16, 6, 0, 0, 0)
    (tmp_path / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"nothing"))
    says = r"bomb.png\": has 8192 x 8192 pixels of 537 MB in all; allowed: a PNG of up to 16384 x 16384 opaque pixels of"
    with pytest.raises(dermis.Error, match=says):  # and not: cannot be read
        dermis.Scene(load={"texture": {"path": tmp_path / "bomb.png", "high": "white"}})


@pytest.mark.parametrize("white", [0.3, 0.7])  # share of the ridges
def test_all_of_a_flat_crest_touches(white):
    ridges = (np.arange(80) % 10 < 10 * white) * np.ones((80, 1))
    spring = dermis.fingertip(  # its strain is the pressure
        grid={"width": 80, "height": 80, "spacing": 1e-4}, surface={"path": ridges},
        load={"kind": "file", "path": np.ones((80, 80)), "contact": "crests", "contact_length": 1e-3},
        material={"modulus": 1, "viscosity": 0}, time={"step": 0.1, "duration": 0.1},
        output={"traces": [], "fields": [{"at": 0.1, "what": ["strain"]}]})
    pressure = dermis.run(spring, precision="f64").fields["strain", 0.1]
    assert (pressure[ridges == 0] == 0).all() and (pressure[ridges == 1] > 0.5 / white).all()
    assert pressure.sum() == pytest.approx(6400)
    with pytest.raises(dermis.Error, match='load.contact = "crests"; allowed: "even" on a flat surface'):
        dermis.run(dermis.fingertip(surface={"kind": "flat"}, load={"contact": "crests", "contact_length": 1e-3}))


def test_maps_in_the_order_of_fortran_are_read(tmp_path):
    numbers = np.random.default_rng(2).random((4, 5))
    for kind in ("<f8", ">f4", "<i2"):
        stored = (100 * numbers).astype(kind)
        np.save(tmp_path / "map.npy", np.asfortranarray(stored))
        np.testing.assert_array_equal(flat(tmp_path / "map.npy"), stored.astype(float))
