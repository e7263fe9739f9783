"""Path tracing of glTF scenes on Vulkan, with pictures as arrays of numpy.

    import raygraph as rg
    scene = rg.load("scene.glb")
    image = rg.render(scene, spp=64)["color"]       # float32, (height, width, 4), linear
    rg.render(scene, spp=64, denoise=True).save("scene.png")

The import opens no device and needs no display. The first call that needs a device opens the default one: the
environment variable RAYGRAPH_DEVICE names it by index or by a part of its name, else it is the most suitable.

Threads: the GIL is released while the library works, on threads of its own; `progress` is called on the caller's. A scene, a picture and a device may be used by several
threads; edits of a scene wait for no render, since a render takes a copy.
"""

import os as _os

from . import _core
from ._core import (Camera, Device, Error, Light, Material, Node, Progress, Scene, __version__, devices,
                    set_default_device)

__all__ = [
    "Camera",
    "Device",
    "Error",
    "Light",
    "Material",
    "Node",
    "Picture",
    "Progress",
    "Scene",
    "compare",
    "devices",
    "explain",
    "load",
    "look_at",
    "merge",
    "read",
    "render",
    "run_pass",
    "set_default_device",
    "verify",
]


def load(path, *, scene="", variant="", points="off", lines="off", env="", root=""):
    """Loads a glTF file (.gltf, .glb), with its animations, and returns a Scene.

    scene, variant: a scene of the file and a variant of its materials, by name or index.
    points, lines: the radius in meters that they are given, or "0.2%" of the scene's size, or "off".
    env: an equirectangular .hdr or .exr that lights the scene.
    root: the folder that files named by the scene are confined to; "": the scene's own.

    Raises Error of kind bad_input that names the file.
    """
    return _core.load(path, str(scene), str(variant), str(points), str(lines), env, root)


def _with_fields(view, fields):
    for name, value in fields.items():
        if name.startswith("_") or not hasattr(type(view), name):
            raise TypeError(f"{name} is no field of a {type(view).__name__.lower()}")
        setattr(view, name, value)
    return view


def _add_material(self, name="", **fields):
    """Adds a material, glTF's default with these fields, as base_color_factor=(1, 0, 0, 1), and returns it."""
    return _with_fields(self._add_material(name), fields)


def _add_light(self, kind, *, name="", parent=None, matrix=None, **fields):
    """Adds a light and the node that places it, and returns the light.

    kind: "point" or "spot", intensity in cd; or "directional", in lx. All shine along -z of the node.
    """
    return _with_fields(self._add_light(kind, name, parent, matrix), fields)


def _add_camera(self, name="", *, orthographic=False, parent=None, matrix=None, **fields):
    """Adds a camera and the node that places it, and returns the camera, which looks along -z of the node.

    fields: y_fov, the vertical angle in radians; or of an orthographic one x_mag and y_mag, half the width and height
    in meters. A scene is seen by its first camera, or by that of render(camera=...).
    """
    return _with_fields(self._add_camera(name, orthographic, parent, matrix), fields)


def _set_environment(self, environment, name="environment"):
    """Lights the scene by an equirectangular map: a .hdr or .exr, or an array of (height, width, 3), linear radiance
    from the top."""
    if isinstance(environment, (str, _os.PathLike)):
        self._load_environment(environment)
    else:
        self._set_environment(environment, name)


Scene.add_material = _add_material
Scene.add_light = _add_light
Scene.add_camera = _add_camera
Scene.set_environment = _set_environment


def look_at(eye, target, up=(0.0, 1.0, 0.0), fov=40.0):
    """Returns a camera for render(): `fov` is the vertical angle in degrees, all else is in meters."""
    return " ".join(repr(float(number)) for number in (*eye, *target, *up, fov))


class Picture(dict):
    """A finished picture: arrays of numpy by name, all views of its memory, (height, width) or (height, width, n).

    color      float32, n = 4: linear radiance and coverage, the mean over the samples
    denoised   float32, n = 4: with denoise
    variance   float32, n = 3: the variance of one sample
    and the AOVs that were asked for: albedo, normal and parts of the light as float32, n = 3; depth as float32,
    in meters along the view, infinite where nothing is hit; instance and material as uint32, 0xFFFFFFFF there.

    In a notebook it shows itself.
    """

    def __init__(self, core):
        super().__init__(core.arrays())
        self._core = core

    def __repr__(self):
        width, height = self.size
        return f"<raygraph.Picture {width}x{height}, {self.samples} samples: {', '.join(self)}>"

    def _repr_png_(self):
        return self._core.png()

    @property
    def display(self):
        """The picture as a screen shows it: uint8, (height, width, 4), sRGB."""
        return self._core.display()

    def save(self, path):
        """Writes a .png or .jpg as `display`, an .exr with all arrays that can be merged and resumed, or an .hdr.

        The file appears whole or not at all. Raises Error of kind io.
        """
        self._core.save(_os.fspath(path))

    @property
    def size(self):
        """Width and height in pixels."""
        return self._core.size

    @property
    def samples(self):
        """Samples of a pixel; of an adaptive picture their mean."""
        return self._core.samples

    @property
    def seconds(self):
        """The time of sampling; 0 for a picture that was read or merged."""
        return self._core.seconds

    @property
    def was_stopped(self):
        """Whether `progress` has ended the render early."""
        return self._core.was_stopped

    @property
    def relative_error(self):
        """Standard error of a pixel over the picture's mean; None if it is not known."""
        return self._core.relative_error

    @property
    def settings(self):
        """Every setting of the picture as text, by its name as an option of `raygraph render`."""
        return self._core.settings

    @property
    def device(self):
        """The name of the device that rendered it."""
        return self._core.device


def _text(value):
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, (tuple, list)) or hasattr(value, "tolist"):
        items = list(value)
        return (";" if items and isinstance(items[0], str) else ",").join(_text(item) for item in items)
    if hasattr(value, "item"):
        value = value.item()
    return value if isinstance(value, str) else repr(value)


def _settings(size, settings):
    names = _core.setting_names()
    texts = {}
    for keyword, value in settings.items():
        name = keyword.rstrip("_").replace("_", "-")
        if name not in names:
            raise TypeError(f"{keyword} is no setting of a picture; there are: "
                            + ", ".join(each.replace("-", "_") for each in names))
        if isinstance(value, Camera):
            value = value.index
        if value is not None:
            texts[name] = _text(value)
    if size is not None:
        width, height = size
        texts["size"] = f"{int(width)}x{int(height)}"
    return texts


def render(scene, spp=None, size=None, *, aovs=(), denoise=False, seconds=None, error=None, sample_offset=0,
           exposure=0.0, tonemap="", white_point=None, resume=None, progress=None, device=None, **settings):
    """Renders a picture of a scene and returns it.

    scene: a Scene, or the path of a file.
    spp: samples per pixel; 64 if neither `seconds` nor `error` is given.
    size: width and height in pixels; 1280 x 720.
    aovs: names of further arrays, as "albedo", "normal", "depth", "instance", "material", "motion", "direct".
    denoise: True, or the name of a denoiser: adds the array `denoised`, which `display` and files show.
    seconds, error: ends earlier, after this time, or when Picture.relative_error is reached.
    sample_offset: index of the first sample; pictures of disjoint ranges can be merged.
    exposure: stops; tonemap: an operator by name; white_point: "auto" or kelvin. Of `display` alone.
    resume: a Picture, or an .exr that `save` or the program has written, to be continued until it has `spp`
        samples, `seconds` have passed or `error` is reached. Settings and aovs that are not given are its own; those
        that differ are refused.
    progress: called with a Progress as samples are added; if it returns False the render ends with what there is.
    device: a Device, or several of one kind; the default one if None.
    settings: every option of `raygraph render` that changes the linear picture, as max_depth=4, seed=1,
        camera="Camera" or look_at(...), background=(1, 1, 1), at=0.5, view="normals".

    A picture has the bits of `raygraph render` with the same options on the same device, however often it was
    interrupted and resumed. Ctrl-C ends it at once with KeyboardInterrupt. Raises Error.
    """
    if not isinstance(scene, Scene):
        scene = load(scene)
    if spp is None and seconds is None and error is None and resume is None:
        spp = 64
    denoiser = denoise if isinstance(denoise, str) else "network" if denoise else ""
    devices_ = [] if device is None else [device] if isinstance(device, Device) else list(device)
    return Picture(_core.render(scene, _settings(size, settings), list(aovs), spp, seconds, error, sample_offset,
                                denoiser, exposure, tonemap, "" if white_point is None else _text(white_point),
                                resume._core if isinstance(resume, Picture) else resume, progress, devices_))


def read(path):
    """Reads an .exr that `save` or `raygraph render` has written. Raises Error of kind bad_input."""
    return Picture(_core.read(_os.fspath(path)))


def merge(pictures):
    """Merges pictures, or .exr files, of different samples of one picture: the result has the bits of one render
    of all these samples. Raises Error of kind bad_input that names the first difference."""
    parts = []
    for index, picture in enumerate(pictures):
        if isinstance(picture, Picture):
            parts.append((f"pictures[{index}]", picture._core))
        else:
            parts.append((_os.fspath(picture), _core.read(_os.fspath(picture))))
    return Picture(_core.merge(parts))


def _judged(name, picture):
    """What the comparing functions take: a path, or radiance with the variance of its mean."""
    if isinstance(picture, Picture):
        counts = picture.get("samples")  # of each pixel of an adaptive picture
        least = picture.samples if counts is None else counts.min()
        variance = None
        if "variance" in picture and least > 1:
            variance = picture["variance"] / (picture.samples if counts is None else counts[..., None])
        return name, picture["color"], variance, picture.samples
    if isinstance(picture, (str, _os.PathLike)):
        return name, _os.fspath(picture)
    return name, picture, None, 0


def compare(reference, picture, *, exposure=0.0, device=None):
    """Compares two pictures of one size, each a Picture, a file or an array (height, width, 3 or 4), linear.

    Returns a dictionary: rel_mse and the share rel_mse_of_noise that noise explains, flip, ssim, mean,
    mean_of_reference, flip_map of (height, width), and where a variance is known z: rms, beyond_three,
    differs_without_noise, of_mean. Numbers are those of `raygraph compare`. Raises Error of kind bad_input.
    """
    return _core.compare(_judged("reference", reference), _judged("picture", picture), exposure, device)


def verify(scene, picture, *, size=None, tolerance=0.05, max_samples=1024, cache="", device=None, **settings):
    """Renders a reference of the scene until it can judge a picture, as `raygraph verify` does, and judges it.

    tolerance: the relative error of a tile and a pixel that is right. cache: a folder that keeps references; "":
    none. settings: those of render(); the size is the picture's.

    Returns the dictionary of compare() with is_right, is_decided, reference_samples, the list `checks` (name, value,
    limit, is_passed, where) and, of a picture that is not right, `causes` (kind, name, text, explained), best first.
    """
    return _core.verify(scene, _judged("picture", picture), _settings(size, settings), tolerance, max_samples,
                        _os.fspath(cache), device)


def explain(scene, pixel, *, size=None, brightest=1, sample=None, first_sample=0, sample_count=64, device=None,
            **settings):
    """Says why a pixel (x, y) of render(scene, ...) has its color, by tracing its samples again.

    Of the samples from first_sample on, so many of the brightest are explained; or `sample` alone.

    Returns a dictionary: text, as `raygraph explain` prints it, mean, relative_error, values of (samples, 3) and the
    list `paths` (sample, value, cause, is_exact, vertices). Raises Error of kind usage.
    """
    return _core.explain(scene, pixel, _settings(size, settings), brightest, sample, first_sample, sample_count, device)


def run_pass(glsl, inputs=None, outputs=None, *, constants=None, groups=None, include="", device=None):
    """Runs a compute shader once, as a pass of the graph, and returns a dictionary of the outputs.

    glsl: its text, from #version on. Bindings of set 0 are known by their names in it.
    inputs: arrays by name: for an image of (height, width) or (height, width, channels), converted to the format that
        the shader declares; for a buffer or a uniform block any array, byte for byte.
    outputs: by name, for an image its (height, width), for a buffer an array of the type and shape of the result. A
        binding that is also an input keeps its contents where the shader writes nothing; its value here is not read,
        but for the type and shape of a buffer, of as many bytes as the input.
    constants: the push constants as an array, such as numpy.float32(0.5) or one of a structured type; of as many bytes
        as the device takes, at least 128.
    groups: (x, y, z) workgroups; None: as many as cover the last image of the outputs.
    include: the folder in which #include looks.

    Images return as float32. Raises Error: of kind bad_input for GLSL that does not compile, with its lines; of kind
    usage for a binding that is missing or of another kind.
    """
    return _core.run_pass(glsl, dict(inputs or {}), dict(outputs or {}), constants, groups, _os.fspath(include), device)
