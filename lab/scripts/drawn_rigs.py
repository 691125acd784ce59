"""Rig files of cameras and lasers that the scripts draw: one text for all, with the values that differ."""

TEXT = """name: {name}
kind: light-section
plane_z_mm: {plane!r}
camera:
  rows: {rows}
  columns: {columns}
  pixel_pitch_um: {pitch!r}
  focal_length_mm: {focal_mm!r}
  frame_rate_hz: {rate!r}
  exposure_us: {exposure!r}
{projector}conveyor:
  speed_mm_per_s: {speed!r}
  encoder_mm_per_count: {encoder!r}
measure:
  mode: grey-over
{measure}  line_width_px: 3
  code_threshold: 5
  max_z_per_line_mm: {max_z!r}
{runs}imaging:
  white: 200
  ambient: 8
  dark: 2
  camera_blur_px: 0.7
  projector_blur_px: 0.7
  electrons_per_grey: 80
  read_noise: 1
  seed: 1
"""
PITCH_UM = 10
LENS = ("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3")
RUNS = {"gap_rows": 1, "ambiguous_from": 0.5}
LIT = {"threshold": 20, "min_lit_px": 3, "max_lit_px": 40}


def section(name, values):
    """A section of a rig file; nothing for no values."""
    return f"{name}:\n" + "".join(f"  {key}: {value!r}\n" for key, value in values.items()) if values else ""


def inner(name, values):
    """A section within another."""
    return "".join("  " + line + "\n" for line in section(name, values).splitlines())


def vector(name, values):
    return {f"{name}_{axis}": value for axis, value in zip("xyz", values)}


def rig(name, size, focal_px, *, plane=1000.0, rate=1, exposure=2, speed=0, encoder=1, measure=None, runs=None,
        max_z_per_line=5, projector=None, lens=None, light=None, belt=None):
    """The text of a rig: `size` (rows, columns); `lens` keys of LENS, 0 where absent; `light` (normal, distance of its
    plane); `belt` (direction, normal)."""
    text = TEXT.format(name=name, plane=plane, rows=size[0], columns=size[1], pitch=PITCH_UM,
                       focal_mm=focal_px * PITCH_UM / 1000, rate=rate, exposure=exposure, speed=speed, encoder=encoder,
                       measure="".join(f"  {key}: {value}\n" for key, value in (measure or LIT).items()),
                       runs=inner("runs", runs), max_z=max_z_per_line, projector=section("projector", projector))
    if lens:
        text += section("camera_lens", {key: lens.get(key, 0) for key in LENS})
    if light:
        text += section("light_plane", {**vector("normal", light[0]), "distance_mm": light[1]})
    if belt:
        text += section("belt_pose", {**vector("direction", belt[0]), **vector("normal", belt[1])})
    return text
