"""Maps and images as PNG, and how objects show themselves in a notebook.

    pathlib.Path("depth.png").write_bytes(selfproj.pictures.map_png(scan.depth, "depth z"))
"""

import base64
import html

import numpy

from ._core.pictures import image_png, map_png

__all__ = ["image_png", "map_png"]

_LONGEST = 1024  # pixels of a side of an image in a notebook


def _img(png, text):
    data = base64.b64encode(png).decode("ascii")
    return f'<img alt="{html.escape(text)}" style="max-width:100%" src="data:image/png;base64,{data}">'


def text_html(text):
    """Text as it is."""
    return f"<pre>{html.escape(text)}</pre>"


def table_html(rows):
    """Rows of named numbers as a table; the first one has the names."""
    names = "".join(f"<th>{html.escape(name)}</th>" for row in rows[:1] for name in row)
    lines = "".join("<tr>" + "".join(f"<td>{value:.6g}</td>" for value in row.values()) + "</tr>" for row in rows)
    return f"<table><tr>{names}</tr>{lines}</table>" if rows else ""


def spacing_of_points(depth, points):
    """Distance of the rays of neighbouring pixels at the median depth, in mm: from row to row, and from column to column.
    depth: (rows, columns); points: those of its pixels with a depth, in the camera's frame."""
    seen = numpy.isfinite(depth)
    if not seen.any():
        return 1.0, 1.0
    rays = numpy.full((*depth.shape, 2), numpy.nan)
    rays[seen] = points[:, :2] / points[:, 2:]
    spacing = []
    for step in (rays[1:] - rays[:-1], rays[:, 1:] - rays[:, :-1]):
        distances = numpy.hypot(step[..., 0], step[..., 1]) * numpy.median(depth[seen])
        spacing.append(float(numpy.nanmedian(distances)) if numpy.isfinite(distances).any() else 1.0)
    return tuple(spacing)


def map_html(values, title, signed=False, spacing=(1.0, 1.0), axes="xy"):
    """A map in mm; one without a value is said to be empty. spacing: from row to row (0: not known) and column to column;
    axes: what runs so."""
    if values.size == 0 or not numpy.isfinite(values).any():
        return text_html(f"{title}: no pixel has a value")
    return _img(map_png(values, title + " (mm)", signed_values=signed, row_mm=spacing[0], column_mm=spacing[1],
                        row_axis=axes[0], column_axis=axes[1]), title)


def image_html(pixels, title):
    """An image, of which large ones are thinned out."""
    step = -(-max(pixels.shape) // _LONGEST)
    small = numpy.ascontiguousarray(pixels[::step, ::step])
    return f"<figure>{_img(image_png(small), title)}<figcaption>{html.escape(title)}</figcaption></figure>"


def curve_html(across, values, across_label, label):
    """A curve with its axes, as SVG; gaps where a value is NaN."""
    across, values = numpy.asarray(across, "float64"), numpy.asarray(values, "float64")
    seen = numpy.isfinite(across) & numpy.isfinite(values)
    if not seen.any():
        return text_html(f"{label}: no column has a value")
    width, height, left, bottom = 640, 240, 70, 40
    low_x, high_x, low_y, high_y = (f(v[seen]) for v in (across, values) for f in (numpy.min, numpy.max))
    span_x, span_y = max(high_x - low_x, 1e-9), max(high_y - low_y, 1e-9)
    x = left + (across - low_x) / span_x * (width - left - 10)
    y = 10 + (high_y - values) / span_y * (height - bottom - 20)
    lines = []
    for piece in numpy.split(numpy.arange(seen.size), numpy.flatnonzero(numpy.diff(seen)) + 1):
        if seen[piece[0]]:
            points = " ".join(f"{x[i]:.1f},{y[i]:.1f}" for i in piece)
            lines.append(f'<polyline points="{points}" fill="none" stroke="#1f5fa8" stroke-width="1.5"/>')
    end = height - bottom
    texts = [(left, end + 16, "start", f"{low_x:.4g}"), (width - 10, end + 16, "end", f"{high_x:.4g}"),
             ((left + width) / 2, height - 6, "middle", across_label), (left - 6, end - 4, "end", f"{low_y:.6g}"),
             (left - 6, 20, "end", f"{high_y:.6g}"), (left - 6, end / 2, "end", label)]
    words = "".join(f'<text x="{a}" y="{b}" text-anchor="{c}">{html.escape(d)}</text>' for a, b, c, d in texts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
            f'font-family="sans-serif" font-size="12"><rect width="{width}" height="{height}" fill="white"/>'
            f'<path d="M{left} 10V{end}H{width - 10}" fill="none" stroke="#444"/>{"".join(lines)}{words}</svg>')


def shows(kind, parts):
    """Gives a class its picture in a notebook: its text, and the HTML that parts(object) lists."""
    kind._repr_html_ = lambda self: text_html(repr(self)) + "".join(parts(self))
