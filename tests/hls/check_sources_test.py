"""The sources of the shells pass their check, and it finds every planted fault, at its line, and nothing else."""

import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "hls"))
import check_sources  # noqa: E402

SHARED = "hls/moments_arithmetic.h"
SHELL = "hls/shells/column_moments_shell.h"

# The kind of fault, and lines that have it; the one with the fault ends in // HERE.
FAULTS = [
    ("dynamic allocation", "inline int* f() { return new int(3); }  // HERE"),
    ("dynamic allocation", "inline void f(int* p) { delete p; }  // HERE"),
    ("dynamic allocation", "inline void* f() { return malloc(16); }  // HERE"),
    ("virtual function", "struct F {\n  virtual int f() { return 1; }  // HERE\n};"),
    ("exception", "inline int f(int a) {\n  if (a < 0) {\n    throw a;  // HERE\n  }\n  return a;\n}"),
    ("standard library", "inline void f(std::vector<int>& v);  // HERE"),
    ("standard library", "inline int f() { return std::max(1, 2); }  // HERE"),
    ("floating point", "inline float f();  // HERE"),
    ("floating point", "constexpr auto kF = 1.5;  // HERE"),
    ("floating point", "constexpr auto kF = 1e3;  // HERE"),
    ("goto", "inline void f() {\nagain:\n  goto again;  // HERE\n}"),
    ("loop without a bound", "inline int f(int a) {\n  while (a > 0) {  // HERE\n    a = a - 1;\n  }\n  return a;\n}"),
    (
        "loop without a bound",
        "inline int f(int a) {\n  do {\n    a = a - 1;  \n  } while (a > 0);  // HERE\n  return a;\n}",
    ),
    (
        "loop whose bounds",
        "inline int f(int n) {\n  int s = 0;\n  for (int i = 0; i < n; ++i) {  // HERE\n    s += i;\n  }\n"
        "  return s;\n}",
    ),
    ("loop whose bounds", "inline int f() {\n  int s = 0;\n  for (;;) {  // HERE\n    s += 1;\n  }\n}"),
    (
        "loop whose bounds",
        "inline int f() {\n  int s = 0;\n  for (int i = 0; i < kLanes; i += 2) {  // HERE\n    s += i;\n  }\n"
        "  return s;\n}",
    ),
    (
        "loop that changes",
        "inline int f() {\n  int s = 0;\n  for (int i = 0; i < kLanes; ++i) {  // HERE\n    i = 0;\n  }\n"
        "  return s;\n}",
    ),
    ("recursion: f", "inline int f(int a) {  // HERE\n  return a == 0 ? 1 : f(a - 1);\n}"),
    (
        "recursion: F::g",
        "struct F {\n  int f(int a) { return g(a); }\n  int g(int a) { return a == 0 ? 1 : f(a - 1); }  // HERE\n};",
    ),
    ("recursion: F::f", "struct F {\n  int f(F& other) { return other.f(*this); }  // HERE\n};"),
    ("header", "#include <algorithm>  // HERE"),
    ("header", '#include "sim/board/shell_ram.h"  // HERE'),
]
SHELL_FAULTS = [
    ("initial value in a record", "struct F {\n  bool a;\n  bool b = false;  // HERE\n};\nstruct G {\n  F f[4];\n};"),
    ("constructor in a record", "struct F {\n  F() { a = false; }  // HERE\n  bool a;\n};\nstruct G {\n  F f[4];\n};"),
    ("process that is not clocked", "struct F {\n  F() { SC_THREAD(f); }  // HERE\n};"),
    (
        "thread f without a reset",
        "struct F {\n  F() { SC_CTHREAD(f, clk_i.pos()); }  // HERE\n  void f() {\n    wait();\n"
        "    while (true) {\n      wait();\n    }\n  }\n};",
    ),
    (
        "thread f without a reset section",
        "struct F {\n  F() {\n    SC_CTHREAD(f, clk_i.pos());\n    reset_signal_is(rst_i, true);\n  }\n"
        "  void f() {  // HERE\n    while (true) {\n      wait();\n    }\n  }\n};",
    ),
    (
        "loop without a bound",
        "struct F {\n  void f() {\n    while (true) {  // HERE\n      if (a.read()) {\n"
        "        wait();\n      }\n    }\n  }\n};",
    ),
    (
        "loop without a bound",
        "struct F {\n  void f() {\n    while (true) {  // HERE\n      if (a.read()) {\n        continue;\n      }\n"
        "      wait();\n    }\n  }\n};",
    ),
    ("method f waits", "struct F {\n  F() { SC_METHOD(f); }\n  void f() { wait(); }  // HERE\n};"),
    ("not for ICSC", "struct F {\n  sc_core::sc_event e;  // HERE\n};"),
    ("not for ICSC", "struct F {\n  sc_core::sc_inout<bool> p;  // HERE\n};"),
    ("a macro of ICSC", "inline void f() { sc_core::sc_start(); }  // HERE"),
    # What ICSC 1.6.8 refused in these shells
    ("call in an argument: finished_m1(", "struct F {\n  void f(Row n) {\n"
     "    word = grey_word(m0, finished_m1(n, m0, m0, a), n);  // HERE\n  }\n};"),
    ("call in an argument: lane_of(", "struct F {\n  void f(Pixels p, Pixel t, ModeBits m) {\n"
     "    w = (w << 8) | weight_of(lane_of(p, 1),  // HERE\n                             t, m);\n  }\n};"),
    ("call in an argument: now(", "struct F {\n  Sum0 now() const { return m0; }\n"
     "  Sum0 f() const { return next_m0(now(), 1); }  // HERE\n};"),
    ("call in an argument: .read()", "struct F {\n  void f() { w = lane_of(pixels_i.read(), 1); }  // HERE\n};"),
    ("constant from a call that is passed on: m", "struct F {\n  Sum0 now() const { return m0; }\n  void f() {\n"
     "    const Sum0 m = now();  // HERE\n    s = next_m0(m, 1);\n  }\n};"),
    ("constant from a call that is passed on: m", "struct F {\n  void f() {\n"
     "    const Pixels m = pixels_i.read();  // HERE\n    s = lane_of(m, 1);\n  }\n};"),
    # What it got wrong
    ("constant that keeps a register: now", "struct F {\n  void f() {\n    const Uint<4> now = at;  // HERE\n"
     "    at = 0;\n    if (now != 0) {\n      at = now + 1;\n    }\n  }\n};"),
]
SHARED_CALLS = [("a number by reference",
                 "template <typename F>\ninline int f(const typename F::Pixels& a);  // HERE"),
                ("a number by reference", "inline int f(const Uint<8>& a);  // HERE"),
                ("call in an argument: lane_of(", "inline Pixel f(Pixels p, Pixel t, ModeBits m) {\n"
                 "  Pixel w = weight_of(lane_of(p, 1), t, m);  // HERE\n  return w;\n}")]
# Code that only looks like a fault.
FINE = [
    "// a new word, delete it, while (true), 1.5",
    'constexpr const char* kName = "new float 1.5";',
    "inline int f(const F& other) {\n  return other.g(1);\n}",
    "inline int f(int a) {\n  int s = a;\n  for (int i = kLanes - 1; i >= 0; --i) {\n    if (i == 2) {\n"
    "      s = s + i;\n    }\n  }\n  return s;\n}",
    "inline Sum0 f(Sum0 m) {\n  const Sum0 n = next_m0(m, 1);\n  Sum0 o = next_m0(m, 2);\n  Sum0 p = next_m0(o, 1);\n"
    "  return p + n;\n}",
]


class CheckSources(unittest.TestCase):
    def files(self):
        return [(str(f.relative_to(ROOT)), f.read_text()) for f in check_sources.files_here()]

    def with_lines(self, name, lines):
        """Returns a file with the lines inside its namespace, and their position."""
        head, tail = (ROOT / name).read_text().split("namespace hls {\n", 1)
        head += "namespace hls {\n"
        return [(name, head + lines + "\n" + tail)], head.count("\n") + 1

    def test_sources_pass(self):
        files = self.files()
        self.assertGreaterEqual(len(files), 9)
        self.assertEqual(check_sources.check(files), [])

    def test_every_fault_is_found(self):
        faults = [(name, *fault) for name in (SHARED, SHELL) for fault in FAULTS] + [
            (SHELL, *fault) for fault in SHELL_FAULTS
        ] + [(SHARED, *fault) for fault in SHARED_CALLS]
        for name, kind, lines in faults:
            with self.subTest(file=name, kind=kind, lines=lines):
                files, first = self.with_lines(name, lines)
                line = first + lines[:lines.index("// HERE")].count("\n")
                findings = check_sources.check(files)
                self.assertTrue(any(f.startswith(f"{name}:{line}: {kind}") for f in findings), findings)
                self.assertTrue(all(f.startswith(f"{name}:") for f in findings), findings)

    def test_what_only_looks_like_a_fault(self):
        for lines in FINE:
            with self.subTest(lines=lines):
                files, _ = self.with_lines(SHARED, lines)
                self.assertEqual(check_sources.check(files), [])


if __name__ == "__main__":
    unittest.main()
