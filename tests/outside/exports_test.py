#!/usr/bin/env python3
"""A shared library exports the functions of its header, and nothing else.

    exports_test.py LIBRARY HEADER PATTERN

PATTERN finds a function in the header, without its comments.
"""

import re
import subprocess
import sys

library, header, pattern = sys.argv[1:]
out = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
exported = {line.split()[2].split("@")[0] for line in out.splitlines() if line.split()[1] != "A"}
with open(header, encoding="utf-8") as file:
    text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.DOTALL)
declared = set(re.findall(pattern, text, flags=re.MULTILINE))
if exported != declared or not declared:
    print(f"only exported: {sorted(exported - declared)}; only declared: {sorted(declared - exported)}")
    sys.exit(1)
print(f"{len(exported)} functions, and nothing else")
