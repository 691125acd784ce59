"""Figures of a measurement with a hidden rig, against the truth of the simulation: for hidden_rigs.py."""

import json
import math
import statistics

import float_tiff

TREADS = (30, 39, 21)  # of experiment A2, from left to right, mm
TREAD_WIDTH = 35
STEP_COLUMNS = 3  # left out on each side of a step, as experiment A2 does it
MARK_REACH = 17  # mm from a mark's median, along the belt and across: marks are 22 mm wide
COLUMN_MM = 0.233  # between columns on the plane
PLANE_Z = 1167  # of the belt of rig A, mm


def spread(rows, reach):
    """Rows of flags, each set where one is set within so many places of its row."""
    out = []
    for row in rows:
        marked = bytearray(len(row))
        for i, flag in enumerate(row):
            if flag:
                low, high = max(0, i - reach), min(len(row), i + reach + 1)
                marked[low:high] = b"\1" * (high - low)
        out.append(marked)
    return out


def near_steps(truth, columns, frames, apart, step=0.3):
    """For each point, whether the truth has a step or a gap within so many columns and frames: a change from one column
    to the next, or from one frame to the one `apart` later. The light slides down a wall over several frames."""
    height, width = len(truth), len(truth[0])
    edges = [bytearray(width) for _ in range(height)]
    for f in range(height):
        for c in range(width):
            here = truth[f][c]
            right = truth[f][c + 1] if c + 1 < width else here
            below = truth[min(f + apart, height - 1)][c]
            if not (abs(here - right) <= step and abs(here - below) <= step):  # NaN is an edge
                edges[f][c] = 1
    edges = spread(edges, columns)
    turned = spread([bytearray(column) for column in zip(*edges)], frames)
    return [bytearray(row) for row in zip(*turned)]


def mark_centroid(inside):
    """The centroid of a carved region, by a grid of 0.05 mm."""
    points = [(i * 0.05, j * 0.05) for i in range(-240, 241) for j in range(-240, 241) if inside(i * 0.05, j * 0.05)]
    return tuple(sum(p[k] for p in points) / len(points) for k in (0, 1))


def in_triangle(right, down):
    """Whether a point is in the strokes of the mark, as sim/scene/scenes.h has it."""
    reach = 9.5

    def segment(r0, d0, r1, d1):
        vr, vd = r1 - r0, d1 - d0
        s = min(1, max(0, ((right - r0) * vr + (down - d0) * vd) / (vr * vr + vd * vd)))
        return math.hypot(right - r0 - s * vr, down - d0 - s * vd)

    return min(segment(-reach, -reach, reach, -reach), segment(reach, -reach, 0, reach),
               segment(0, reach, -reach, -reach)) <= 1.5


def undistorted(lens, x, y):
    """Brown's formula, inverted by fixed points."""
    u, v = x, y
    for _ in range(60):
        r2 = u * u + v * v
        radial = 1 + r2 * (lens["k1"] + r2 * (lens["k2"] + r2 * lens["k3"]))
        u = (x - 2 * lens["p1"] * u * v - lens["p2"] * (r2 + 2 * u * u)) / radial
        v = (y - lens["p1"] * (r2 + 2 * v * v) - 2 * lens["p2"] * u * v) / radial
    return u, v


class TrueCamera:
    """The camera of the hidden rig, as the simulation has it."""

    def __init__(self, folder):
        self.view = json.loads((folder / "board/truth.json").read_text(encoding="utf-8"))["camera"]

    def place(self, row, column, z):
        """x and y of the world at which a pixel sees the plane z."""
        view = self.view
        u, v = undistorted(view["distortion"], (column - view["column_centre_px"]) / view["column_focal_px"],
                           (row - view["row_centre_px"]) / view["row_focal_px"])
        ray = [u * a + v * b + c for a, b, c in zip(view["along_columns"], view["along_rows"], view["axis"])]
        way = (z - view["centre_mm"][2]) / ray[2]
        return tuple(view["centre_mm"][k] + way * ray[k] for k in (0, 1))


def points_of_marks(folder, spacing):
    """For each mark its points (frame, column, x, y), in the part's frame: what lies 0.5 to 1.5 mm deeper than the
    good part within half a tread of its own median; None if one has no points."""
    points = []
    with open(folder / "result/profile.csv", encoding="utf-8") as lines:
        next(lines)
        for line in lines:
            fields = line.split(",")
            if 0.5 < float(fields[7]) < 1.5:
                points.append((int(fields[0]), int(fields[1]), float(fields[2]) - spacing * int(fields[0]),
                               float(fields[3])))
    marks = []
    middle = statistics.median(p[3] for p in points)
    for tread in range(len(TREADS)):
        own = [p for p in points if abs(p[3] - middle - TREAD_WIDTH * (tread - 1)) < TREAD_WIDTH / 2]
        if not own:
            return None
        around = [statistics.median(p[k] for p in own) for k in (2, 3)]
        marks.append([p for p in own if all(abs(p[2 + k] - around[k]) < MARK_REACH for k in (0, 1))])
    return marks


def beside_each_other(found, true):
    """How far places are from the true ones, relative to each other: the part may lie anywhere on the belt."""
    shift = [statistics.fmean(f[k] - t[k] for f, t in zip(found, true)) for k in (0, 1)]
    return max(math.hypot(f[0] - t[0] - shift[0], f[1] - t[1] - shift[1]) for f, t in zip(found, true))


def marks_figures(folder, spacing, truth):
    """How far the marks' points are from where they truly are, and the centroid of what is seen of each mark from the
    mark's own. The latter is off even with a rig that is known perfectly: the light falls in from one side, and a wall
    1 mm high shades 0.6 mm of a mark's bottom."""
    marks = points_of_marks(folder, spacing)
    if not marks:
        return {"place_mm": math.inf, "centroid_mm": math.inf}
    rows = {}
    with open(folder / "result/moments.csv", encoding="utf-8") as lines:
        next(lines)
        for line in lines:
            frame, column, m0, m1, _ = line.split(",")
            if int(m0) > 0:
                rows[int(frame), int(column)] = int(m1) / int(m0) - 1
    camera = TrueCamera(folder)
    found, true = [], []
    for points in marks:
        pairs = []
        for frame, column, x, y in points:
            height = truth[frame - 1][column - 1]
            if not math.isnan(height):
                at = camera.place(rows[frame, column], column - 1, PLANE_Z - height)
                pairs.append((x, y, at[0] - spacing * frame, at[1]))
        found.append([statistics.fmean(p[k] for p in pairs) for k in (0, 1)])
        true.append([statistics.fmean(p[k] for p in pairs) for k in (2, 3)])
    down = mark_centroid(in_triangle)[1]
    drawn = [(0, -TREAD_WIDTH), (0, 0), (-down, TREAD_WIDTH)]
    seen = [[statistics.fmean(p[k] for p in points) for k in (2, 3)] for points in marks]
    return {"place_mm": beside_each_other(found, true), "centroid_mm": beside_each_other(seen, drawn)}


def light_section_figures(folder, spacing):
    """Heights and marks of A2; `spacing` is that of the frames in mm."""
    height, truth = float_tiff.read(folder / "result/height.tiff"), float_tiff.read(folder / "truth.tiff")
    reach = math.ceil(STEP_COLUMNS * COLUMN_MM / spacing)
    edges = near_steps(truth, STEP_COLUMNS, reach, apart=reach)
    count = total = squares = greatest = missing = 0
    treads = [[0.0, 0] for _ in TREADS]
    for measured, true, edge in zip(height, truth, edges):
        for h, t, left_out in zip(measured, true, edge):
            if left_out or math.isnan(t):
                continue
            if math.isnan(h):
                missing += t > 10  # the belt before the part is out of the image
                continue
            error = h - t
            count, total, squares = count + 1, total + error, squares + error * error
            greatest = max(greatest, abs(error))
            for i, tread in enumerate(TREADS):
                if abs(t - tread) < 0.1:
                    treads[i][0] += h
                    treads[i][1] += 1
    found = [s / n if n else math.nan for s, n in treads]
    return {"treads_mm": found, "tread_mm": max(abs(f - t) for f, t in zip(found, TREADS)),
            "mean_mm": total / count, "rms_mm": math.sqrt(squares / count), "max_mm": greatest, "points": count,
            "missing": missing, **marks_figures(folder, spacing, truth)}


def scanner_figures(folder):
    """The measured depths of the plane against the true ones along the true rays of the same pixels."""
    truth = json.loads((folder / "board/truth.json").read_text(encoding="utf-8"))["camera"]
    plane = json.loads((folder / "depth/summary.json").read_text(encoding="utf-8"))["plane"]
    depth = float_tiff.read(folder / "depth/depth.tiff")
    plane_z = 550
    # the plane in the camera's frame: n . p = distance, with the world's z along the camera's axes
    normal = [truth[name][2] for name in ("along_columns", "along_rows", "axis")]
    distance = plane_z - truth["centre_mm"][2]
    errors = []
    for row in range(0, len(depth), 4):
        for column in range(0, len(depth[row]), 4):
            if not math.isnan(depth[row][column]):
                u, v = undistorted(truth["distortion"], (column - truth["column_centre_px"]) / truth["column_focal_px"],
                                   (row - truth["row_centre_px"]) / truth["row_focal_px"])
                z = distance / (normal[0] * u + normal[1] * v + normal[2])
                errors.append((u * z, v * z, depth[row][column] - z))
    # the error's plane a + b x + c y: where the measured plane lies
    a, b, c = fitted(errors)
    xs, ys = [e[0] for e in errors], [e[1] for e in errors]
    corners = [a + b * x + c * y for x in (min(xs), max(xs)) for y in (min(ys), max(ys))]
    return {"on_axis_mm": plane["z_on_axis_mm"] - distance / normal[2], "plane_mm": max(map(abs, corners)),
            "middle_mm": a + b * (min(xs) + max(xs)) / 2 + c * (min(ys) + max(ys)) / 2,
            "residual_mm": plane["residual_rms_mm"], "rounding_mm": plane["rounding_rms_mm"],
            "points": plane["points"]}


def fitted(points):
    """Least squares of e = a + b x + c y, by normal equations around the means."""
    n = len(points)
    mx, my, me = (sum(p[k] for p in points) / n for k in (0, 1, 2))
    xx = sum((p[0] - mx) ** 2 for p in points)
    yy = sum((p[1] - my) ** 2 for p in points)
    xy = sum((p[0] - mx) * (p[1] - my) for p in points)
    xe = sum((p[0] - mx) * (p[2] - me) for p in points)
    ye = sum((p[1] - my) * (p[2] - me) for p in points)
    determinant = xx * yy - xy * xy
    b, c = (yy * xe - xy * ye) / determinant, (xx * ye - xy * xe) / determinant
    return me - b * mx - c * my, b, c
