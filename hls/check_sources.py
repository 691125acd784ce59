#!/usr/bin/env python3
"""check_sources.py [FILE...]: finds what synthesis tools refuse in the sources of hls/, or in FILEs.

Everywhere these are findings: dynamic allocation, virtual functions, exceptions and run-time types, the standard
library except its integers, floating point, goto, loops whose bounds are not constants, recursion, and headers that do
not belong to the shells. In files under a folder `shells` there are more: processes other than methods and clocked
threads with a synchronous reset; threads without a reset section, or with a path without wait(); whatever the open
compiler ICSC does not take. ICSC 1.6.8 refuses some calls in arguments of other calls, and some constants that come
from a call and are passed on. Here all of them are findings, in the functions outside of classes in other headers too,
because the shells call those. It refuses arrays of records that give their members initial values or have a
constructor, wherever these are defined. A constant that keeps the value of a register, which then gets a literal one,
it takes for that literal; and a register that only functions with references read may become none.

It prints one line a finding, and its exit status is then 1.
"""
import functools
import pathlib
import re
import sys

FOLDER = pathlib.Path(__file__).resolve().parent

HEADERS = re.compile(r'"(hls/[\w/]+\.h|selfproj/model/generated/selfproj_spec\.h)"|<(cstdint|cstddef|systemc)>')
# A number of a shell
NUMBER = r"(?:typename\s+F::\w+|(?:Wide|Any)?Uint<[^<>]*>|Pixels?|Row|Sum[01])"
WORDS = [
    ("dynamic allocation", r"\b(new|delete|malloc|calloc|realloc|free|alloca)\b"),
    ("virtual function", r"\b(virtual|override|dynamic_cast|typeid)\b"),
    ("exception", r"\b(throw|try|catch)\b"),
    ("standard library", r"\bstd\s*::\s*(?!u?int(8|16|32|64)_t\b|size_t\b)\w+"),
    ("floating point", r"\b(float|double)\b|\bhalf\s+\w|\b\d+\.\d*|\.\d+\b|\b\d+[eE][-+]?\d+\b"),
    ("goto", r"\bgoto\b"),
]
# In the pure functions, which a shell may call with a register
PURE_WORDS = [("a number by reference", rf"\bconst\s+{NUMBER}\s*&")]
SHELL_WORDS = [
    (
        "not for ICSC",
        r"\b(sc_event|sc_fifo|sc_mutex|sc_semaphore|sc_buffer|sc_inout|sc_export|sc_logic|sc_lv|sc_bv|sc_bit|"
        r"sc_signal_resolved|sc_signal_rv|sc_fixed|sc_ufixed|sc_time|sc_spawn|SC_FORK)\b",
    ),
    ("process that is not clocked", r"\bSC_THREAD\b"),
    ("not for ICSC", r"\b(next_trigger|notify|const_cast|reinterpret_cast)\b"),
    ("a macro of ICSC behind a namespace", r"\bsc_core\s*::\s*sc_start\b"),
]
PORT_CALLS = ("read", "write")  # of ports and signals, which every compiler knows
KEYWORDS = {
    "if", "for", "while", "switch", "return", "sizeof", "static_cast", "static_assert", "defined", "alignof",
    "decltype",
}


def blank(match):
    """Returns spaces in place of a text, with its line breaks."""
    return re.sub(r"[^\n]", " ", match.group())


def seen(text):
    """Returns the source without comments, with the same lines."""
    return re.sub(r"//[^\n]*|/\*.*?\*/", blank, text, flags=re.S)


def closing(text, start):
    """Returns the position behind the bracket that closes the one at `start`."""
    pairs = {"{": "}", "(": ")"}
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] == text[start]) - (text[i] == pairs[text[start]])
        if depth == 0:
            return i + 1
    return len(text)


class Source:
    def __init__(self, name, text, shell):
        self.name = name
        self.shell = shell
        self.text = seen(text)
        self.code = re.sub(r'"(\\.|[^"\\\n])*"', blank, re.sub(r"^\s*#[^\n]*", blank, self.text, flags=re.M))
        self.findings = []

    def find(self, at, what):
        self.findings.append((self.text.count("\n", 0, at) + 1, what))

    def check(self):
        for include in re.finditer(r'^\s*#\s*include\s+(\S+)', self.text, flags=re.M):
            if not HEADERS.fullmatch(include.group(1)):
                self.find(include.start(1), f"header {include.group(1)}")
        for what, pattern in WORDS + (SHELL_WORDS if self.shell else PURE_WORDS):
            for word in re.finditer(pattern, self.code):
                self.find(word.start(), f"{what}: {' '.join(word.group().split())}")
        self.check_loops()
        if self.shell:
            self.check_processes()

    # --- Loops ---

    def check_loops(self):
        constant = r"[\s\d()+\-*/]*(?:\b(?:F::)?k[A-Z]\w*\b[\s\d()+\-*/]*)*"
        counted = re.compile(rf"\(\s*int (\w+) = {constant};\s*\1 (?:<|<=|>|>=|!=) {constant};\s*(?:\+\+|--)\1\s*\)")
        for loop in re.finditer(r"\b(for|while|do)\b", self.code):
            if loop.group() == "for":
                head = counted.match(self.code, self.code.index("(", loop.start()))
                if not head:
                    self.find(loop.start(), "loop whose bounds are not constants")
                    continue
                start = head.end()
                while self.code[start].isspace():
                    start += 1
                body = self.code[start:closing(self.code, start)] if self.code[start] == "{" else ""
                if re.search(rf"\b{head.group(1)}\s*([-+*/|&^]|<<|>>)?=[^=]|(\+\+|--)\s*{head.group(1)}\b", body):
                    self.find(loop.start(), "loop that changes its own counter")
            elif not (self.shell and loop.group() == "while" and self.is_thread_loop(loop.start())):
                self.find(loop.start(), "loop without a bound")

    def is_thread_loop(self, at):
        head = re.compile(r"while\s*\(\s*true\s*\)\s*\{").match(self.code, at)
        return head and self.waits(self.code[head.end():closing(self.code, head.end() - 1) - 1])

    @staticmethod
    def waits(body):
        """Returns whether every path through a block reaches a wait() statement before anything leaves the block."""
        waits = re.search(r"(?:^|[;}]|\s)\s*wait\(\);", flat(body))
        return waits and not re.search(r"\b(continue|break|return)\b", body)

    # --- Processes of a shell ---

    def check_processes(self):
        for process in re.finditer(
            r"\bSC_CTHREAD\(\s*(\w+)\s*,\s*\w+\.pos\(\)\s*\)\s*;\s*(reset_signal_is\()?", self.code
        ):
            if not process.group(2):
                self.find(process.start(), f"thread {process.group(1)} without a reset")
            body = re.search(rf"\bvoid {process.group(1)}\(\)\s*\{{", self.code)
            if not body:
                self.find(process.start(), f"thread {process.group(1)} is not defined here")
                continue
            code = self.code[body.end():closing(self.code, body.end() - 1)]
            loop = code.find("while")
            if loop < 0 or not self.waits(code[:loop]):
                self.find(body.start(), f"thread {process.group(1)} without a reset section that ends in wait()")
        for process in re.finditer(r"\bSC_CTHREAD\b(?!\(\s*\w+\s*,\s*(?:this->)?\w+\.pos\(\)\s*\)\s*;)", self.code):
            self.find(process.start(), "thread whose clock edge is not a port's pos()")
        for process in re.finditer(r"\bSC_METHOD\(\s*(\w+)\s*\)", self.code):
            body = re.search(rf"\bvoid {process.group(1)}\(\)\s*\{{", self.code)
            if body and re.search(r"\bwait\s*\(", self.code[body.end():closing(self.code, body.end() - 1)]):
                self.find(body.start(), f"method {process.group(1)} waits")

    # --- Functions ---

    def start_of(self, body, name, at):
        """Returns where the body of a function begins, from what functions() says of it."""
        return self.code.index(body, self.code.index("{", at + len(name)))

    def functions(self):
        """(class or "", name, place, code of the body, the types of its class's members and of its parameters)"""
        classes = []
        for head in re.finditer(r"\b(?:class|struct)\s+(\w+)[^;{()]*\{", self.code):
            classes.append((head.group(1), head.end(), closing(self.code, head.end() - 1)))
        heads = re.compile(r"\b(?:(\w+)::)?(\w+)\s*(\((?:[^(){};]|\([^()]*\))*\))\s*(?:const\s*)?(?::[^{};]*)?\{")
        for head in heads.finditer(self.code):
            if head.group(2) in KEYWORDS:
                continue
            owner = head.group(1) or ""
            around = ""
            for name, start, end in classes:  # the innermost is the last that begins before it
                if start <= head.start() < end:
                    owner, around = name, self.code[start:end]
            body = self.code[head.end():closing(self.code, head.end() - 1)]
            yield owner, head.group(2), head.start(), body, around + head.group(3) + body


def arguments(body, names):
    """Yields the arguments of every call of a function of these names in the body, with their place."""
    for call in re.finditer(rf"\b({'|'.join(sorted(names))})\s*\(", body):
        yield body[call.end():closing(body, call.end() - 1) - 1], call.end()


def called_names(sources):
    """Returns the names of the functions in the sources, without constructors."""
    functions = [function for source in sources for function in source.functions()]
    return {name for _, name, *_ in functions} - {owner for owner, *_ in functions} - set(PORT_CALLS)


@functools.cache
def names_here():
    """Returns the names of the functions of hls/, which any source may call."""
    return called_names([Source(str(f), f.read_text(), False) for f in files_here()])


def calls(sources):
    """Finds what ICSC refuses: calls in the arguments of calls, and constants from a call that are passed on."""
    functions = [(source, *function) for source in sources for function in source.functions()]
    names = called_names(sources) | names_here()
    any_call = re.compile(rf"\b({'|'.join(sorted(names))})\s*\(|\.\s*read\s*\(\s*\)")
    constant = re.compile(r"\bconst\s+\w+(?:<[^;(){}]*>)?\s*&?\s*(\w+)\s*=([^;]*);")
    for source, owner, name, at, body, _ in functions:
        if owner and not source.shell:
            continue
        start = source.start_of(body, name, at)
        for text, place in arguments(body, names):
            if inner := any_call.search(text):
                source.find(start + place + inner.start(), "call in an argument: " + " ".join(inner.group().split()))
        for local in constant.finditer(body):
            passed = any(re.search(rf"\b{local.group(1)}\b", text) for text, _ in arguments(body, names))
            if passed and any_call.search(local.group(2)):
                source.find(start + local.start(), f"constant from a call that is passed on: {local.group(1)}")


def kept(sources):
    """Finds what ICSC gets wrong: constants that keep the value of a register, which then gets a literal value."""
    copy = re.compile(r"\bconst\s+\w+(?:<[^;(){}]*>)?\s+(\w+)\s*=\s*(\w+);")
    for source in sources:
        for _, name, at, body, _ in source.functions():
            start = source.start_of(body, name, at)
            for local in copy.finditer(body):
                if re.search(rf"\b{local.group(2)}\s*=\s*(\d\w*|true|false)\s*;", body[local.end():]):
                    source.find(start + local.start(), f"constant that keeps a register: {local.group(1)}")


def flat(body):
    """Returns the code of a block without what is in its inner blocks."""
    while (inner := re.sub(r"\{[^{}]*\}", blank, body)) != body:
        body = inner
    return body


def records(sources):
    """Finds what ICSC refuses: records in arrays of shells that give their members values, or have a constructor."""
    in_arrays = {array.group(1) for source in sources if source.shell
                 for array in re.finditer(r"\b(\w+) \w+\[[^\]]*\];", source.code)}
    for source in sources:
        for head in re.finditer(r"\bstruct\s+(\w+)\s*\{", source.code):
            if head.group(1) not in in_arrays:
                continue
            body = flat(source.code[head.end():closing(source.code, head.end() - 1) - 1])
            for member in re.finditer(rf"[^;}}]*?\b(?:(\w+\s*=)[^=;]|({head.group(1)}\s*\())", body):
                what = "initial value" if member.group(1) else "constructor"
                if "constexpr" not in member.group():
                    source.find(head.end() + member.start(member.lastindex), f"{what} in a record of an array")


def recursion(sources):
    """Finds functions that call themselves, directly or through others."""
    functions = {}
    for source in sources:
        for owner, name, at, body, around in source.functions():
            functions.setdefault((owner, name), []).append((source, at, body, around))
    classes = {owner for owner, _ in functions if owner}
    calls = {}
    for (owner, name), bodies in functions.items():
        called = calls.setdefault((owner, name), set())
        for _, _, body, around in bodies:
            for call in re.finditer(r"(?:\b(\w+)\s*(?:\[[^\]]*\])?\s*(\.|->|::)\s*)?\b(\w+)\s*\(", body):
                target, how, what = call.group(1), call.group(2), call.group(3)
                if not target or target == "this":
                    called.add((owner, what) if (owner, what) in functions else ("", what))
                elif how == "::":
                    called.add((target, what))
                else:
                    declared = re.findall(rf"\b(\w+)\s*(?:<[^;(){{}}]*>)?[\s&]+{target}\b", around)
                    kinds = [kind for kind in declared if kind in classes]
                    # If the type of an object is not known: any class with such a function.
                    called.update((kind, what) for kind in (kinds or ([] if declared else classes)))
    found = set()
    for function in functions:
        reached, new = set(), {function}
        while new:
            new = {other for one in new for other in calls.get(one, ()) if other in functions} - reached
            reached |= new
        if function in reached and function not in found:
            found.add(function)
            source, at, _, _ = functions[function][0]
            source.find(at, f"recursion: {'::'.join(filter(None, function))}")


def check(files):
    """files: (name, text). The findings as lines of text."""
    sources = [Source(name, text, "shells" in pathlib.PurePath(name).parts) for name, text in files]
    for source in sources:
        source.check()
    recursion(sources)
    calls(sources)
    records(sources)
    kept([source for source in sources if source.shell])
    return [f"{source.name}:{line}: {what}" for source in sources for line, what in sorted(source.findings)]


def files_here():
    return sorted(f for pattern in ("*.h", "shells/*.h") for f in FOLDER.glob(pattern))


def main():
    files = [pathlib.Path(name) for name in sys.argv[1:]] or files_here()
    try:
        findings = check(
            [(str(f.relative_to(FOLDER.parent) if FOLDER in f.parents else f), f.read_text()) for f in files]
        )
    except OSError as error:
        print(f"check_sources.py: {error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    for finding in findings:
        print(finding, file=sys.stderr)
    if not findings:
        print(f"check_sources.py: {len(files)} files hold nothing that synthesis refuses")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
