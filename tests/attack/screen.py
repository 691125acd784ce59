"""A display that belongs to the attack: no attack shows anything on the display of whoever runs it."""
import contextlib
import os
import subprocess

COLUMNS, ROWS = 64, 16  # those of the images among the materials


@contextlib.contextmanager
def own_screen():
    """Gives all programs a display of Xvfb, or none where Xvfb is not installed. Yields whether there is one."""
    os.environ.pop("DISPLAY", None)
    os.environ.pop("WAYLAND_DISPLAY", None)
    reader, writer = os.pipe()
    try:
        server = subprocess.Popen(["Xvfb", "-displayfd", str(writer), "-screen", "0", f"{COLUMNS}x{ROWS}x24",
                                   "-nolisten", "tcp", "-noreset", "-nocursor"],
                                  pass_fds=[writer], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL, start_new_session=True)
    except FileNotFoundError:
        server = None
    os.close(writer)
    try:
        with os.fdopen(reader) as answer:
            number = answer.readline().strip()
        if number:
            os.environ["DISPLAY"] = f":{number}"
        yield bool(number)
    finally:
        if server:
            server.terminate()
            server.wait()
