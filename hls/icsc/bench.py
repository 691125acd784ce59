#!/usr/bin/env python3
"""bench.py SHELL...: prints a SystemC program that holds the shells.

The shells are column_moments, column_runs, gray_decoder, median3x3 and verdict.

Each is in a module that binds every port to a signal of its own: SystemC elaborates no module with an open port.

ICSC translates one shell at a time, `top.shell`. With several shells, the modules have their names instead of `top`.
The ports are read from the headers in hls/shells/, so that only those list them.
"""
import pathlib
import re
import sys

SHELLS = pathlib.Path(__file__).resolve().parents[1] / "shells"
PORT = re.compile(r"sc_core::sc_(?:in|out)<\w+(?:<\w+>)?> (\w+)\{")


def source(name):
    """Returns the text of a shell's header, with the ports that it inherits before its own."""
    text = (SHELLS / f"{name}_shell.h").read_text()
    inherited = re.findall(r'#include "hls/shells/(\w+_ports\.h)"', text)
    return "".join((SHELLS / file).read_text() for file in inherited) + text


def bench(name, text, instance):
    """Returns the module around a shell, and its name, from the text of the shell's header."""
    shell = re.search(r"class (\w+Shell) : public ", text)[1]
    ports = PORT.findall(text)
    signals = "\n".join(f'  sc_core::sc_signal<decltype({shell}::{port})::data_type> {port}{{"{port}"}};'
                        for port in ports)
    binds = "\n".join(f"    shell.{port}({port});" for port in ports)
    return f"""
namespace selfproj {{
namespace hls {{
struct {shell}Bench : public sc_core::sc_module {{
  {shell} shell{{"shell"}};
{signals}

  explicit {shell}Bench(const sc_core::sc_module_name& name) : sc_module(name) {{
{binds}
  }}
}};
}}  // namespace hls
}}  // namespace selfproj
""", f'  selfproj::hls::{shell}Bench {name}("{instance}");'


def program(names):
    texts = {name: source(name) for name in names}
    benches = [bench(name, text, name if len(names) > 1 else "top") for name, text in texts.items()]
    includes = "\n".join(f'#include "hls/shells/{name}_shell.h"' for name in names)
    instances = "\n".join(instance for _, instance in benches)
    # sc_start is a macro in ICSC's SystemC: no namespace may stand before it.
    return f"""#include <systemc>

{includes}
{''.join(module for module, _ in benches)}
int sc_main(int, char**) {{
{instances}
  using namespace sc_core;
  sc_start();
  return 0;
}}
"""


def main():
    names = sys.argv[1:]
    known = sorted(path.name.removesuffix("_shell.h") for path in SHELLS.glob("*_shell.h"))
    if not names or not set(names) <= set(known):
        print(f"bench.py: names of shells are missing or unknown; there are {', '.join(known)}", file=sys.stderr)
        return 2
    print(program(names), end="")
    return 0


if __name__ == "__main__":
    sys.exit(main())
