"""Pictures for the tests, made by NumPy alone: bits of Gray codes, and a chessboard seen under patterns."""

import numpy


def gray_bits(columns, rows):
    """The bit of every projector pixel under each positive, columns first, most significant bit first."""
    planes = []
    for axis, side in ((1, columns), (0, rows)):
        count = max(1, (side - 1).bit_length())
        code = numpy.arange(side) ^ numpy.arange(side) >> 1
        for bit in reversed(range(count)):
            line = code >> bit & 1
            planes.append(numpy.broadcast_to(line[None, :] if axis == 1 else line[:, None], (rows, columns)))
    return planes


def turned(x, y):
    """A rotation about x, then y, in radians."""
    about_x = numpy.array([[1, 0, 0], [0, numpy.cos(x), -numpy.sin(x)], [0, numpy.sin(x), numpy.cos(x)]])
    about_y = numpy.array([[numpy.cos(y), 0, numpy.sin(y)], [0, 1, 0], [-numpy.sin(y), 0, numpy.cos(y)]])
    return about_y @ about_x


POSES = [(0.0, 0.0), (0.35, 0.1), (-0.3, 0.25), (0.1, -0.4), (-0.2, -0.2)]


def chessboard_rays(rows, columns, fine):
    """The rays of the sub-pixels, fine along each side of a pixel, of a camera with a focal length of 400 px."""
    camera = numpy.array([[400, 0, (columns - 1) / 2], [0, 400, (rows - 1) / 2], [0, 0, 1.0]])
    y, x = numpy.mgrid[0:rows * fine, 0:columns * fine]
    rays = numpy.stack([(x + 0.5) / fine - 0.5, (y + 0.5) / fine - 0.5, numpy.ones(x.shape)], -1)
    return rays @ numpy.linalg.inv(camera).T


def chessboard_seen(rays, angles, moved=0):
    """The points of a 7 x 5 chessboard, squares of 40 mm, that the rays meet, and its albedo there. It was moved by so
    many mm along the camera's rows."""
    board, corner = turned(*angles), numpy.array([-120, -80 + moved, 780.0])
    points = rays * ((board[:, 2] @ corner) / (rays @ board[:, 2]))[..., None]
    place = (points - corner) @ board / 40
    dark = (numpy.floor(place[..., 0]) + numpy.floor(place[..., 1])) % 2 == 0
    on_board = (abs(place[..., 0] - 3) < 4) & (abs(place[..., 1] - 2) < 3)
    return points, numpy.where(on_board & dark, 60.0, 200.0)


def plain_image(light, fine=3):
    """The image of the light of sub-pixels."""
    rows, columns = (side // fine for side in light.shape)
    return numpy.clip(light.reshape(rows, fine, columns, fine).mean((1, 3)), 0, 255).astype("uint8")


def laser_poses(normal, distance):
    """Images of the chessboard in five poses, and the same with a laser's line: normal . point = distance, mm."""
    rays = chessboard_rays(240, 320, 3)
    boards, lines = [], []
    for angles in POSES:
        points, albedo = chessboard_seen(rays, angles)
        boards.append(plain_image(20 + 0.8 * albedo))
        lines.append(plain_image(5 + 1.2 * albedo * numpy.exp(-0.5 * ((points @ normal - distance) / 1.5) ** 2)))
    return boards, lines


def belt_places(places):
    """Images of the chessboard at these places, mm, of a belt that moves along the camera's rows."""
    rays = chessboard_rays(240, 320, 3)
    return [plain_image(20 + 0.8 * chessboard_seen(rays, (0, 0), place)[1]) for place in places]


def gray_images(codes, bits):
    """Images under Gray codes, positives and negatives by turns, of a camera whose pixels see these codes."""
    gray = codes ^ codes >> 1
    planes = [gray >> bit & 1 for bit in reversed(range(bits))]
    return numpy.stack([20 + 180 * (plane ^ negative) for plane in planes for negative in (0, 1)]).astype("uint8")


def write_chessboard_poses(folder, sequence):
    """Writes the images of a 7 x 5 chessboard, squares of 40 mm, in five poses under a sequence of 96 x 80 patterns.
    Returns the folders."""
    rows, columns, fine = 240, 320, 3  # fine: places along a side of a pixel
    projector = numpy.array([[130, 0, 47.5], [0, 130, 39.5], [0, 0, 1.0]])
    rotation, translation = turned(0, 0.25), numpy.array([-220, 0, 40.0])
    rays = chessboard_rays(rows, columns, fine)
    folders = []
    for pose, angles in enumerate(POSES):
        points, white = chessboard_seen(rays, angles)
        lit = (points @ rotation.T + translation) @ projector.T
        column, row = (numpy.rint(lit[..., i] / lit[..., 2]).astype(int) for i in (0, 1))
        inside = (column >= 0) & (column < 96) & (row >= 0) & (row < 80)
        column, row = numpy.clip(column, 0, 95), numpy.clip(row, 0, 79)
        path = folder / f"pose_{pose}"
        path.mkdir()
        for index in range(sequence.count):
            light = 20 + white * inside * (sequence.image(index)[row, column] / 255.0)
            image = light.reshape(rows, fine, columns, fine).mean((1, 3)).astype("uint8")
            (path / f"image_{index:02}.pgm").write_bytes(b"P5\n%d %d\n255\n" % (columns, rows) + image.tobytes())
        folders.append(path)
    return folders
