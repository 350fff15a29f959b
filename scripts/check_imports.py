#!/usr/bin/env python3
"""Checks that imports point downwards, that every library of others stays inside its one adapter, that no two files or
types have one name, and that a file includes the standard headers of what it uses.

usage: scripts/check_imports.py [--headers [--build DIR]]
  --headers    also compiles alone every header that no source includes first, with the flags of DIR/compile_commands.json (default: build/release)

Each edge that breaks a rule is named as "file:line: ...". Exit status 1 if there is any.
"""
import argparse
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

# What each room may include. A room may always include itself.
MAY_INCLUDE = {
    "core": set(),
    "threading": {"core"},
    "mesher": {"core", "threading"},
    "adapt": {"core", "threading"},
    "apps": {"core", "threading", "mesher", "adapt"},
    "python": {"core", "threading", "mesher", "adapt"},
    "bench": {"core", "threading", "mesher", "adapt"},
    "examples": {"core", "threading", "mesher", "adapt"},
    "tests": {"core", "threading", "mesher", "adapt", "apps", "bench", "examples"},
}

# The same inside a room whose folders stand in an order.
FOLDER_MAY_INCLUDE = {
    "threading/runtime": set(),
    "threading/comm": {"threading/runtime"},
    "threading/parts": {"threading/runtime", "threading/comm"},
    "threading/balance": {"threading/runtime", "threading/comm", "threading/parts"},
    "threading/geometry": {"threading/runtime", "threading/comm"},
}

# Public headers (include/tetloom) and the rooms whose declarations they hold.
PUBLIC = {
    "core": {"assert", "check", "error", "host", "ids", "io", "mesh_data", "model", "part_mesh",
             "size_field", "storage", "vec"},
    "threading": {"communicator", "partition", "tasks"},
    "mesher": {"filling", "layers", "mesh"},
    "adapt": {"adapt", "metric"},
}

# (what, headers that belong to it, files that may include them)
ADAPTERS = [
    ("oneTBB", re.compile(r"^(tbb|oneapi)/"), re.compile(r"^threading/")),
    ("Scotch", re.compile(r"^scotch\.h$"), re.compile(r"^threading/balance/scotch_partitioner\.cpp$")),
    ("Zoltan", re.compile(r"^zoltan\.h$"), re.compile(r"^threading/balance/zoltan_partitioner\.cpp$")),
    ("MPI", re.compile(r"^mpi\.h$"),
     re.compile(r"^threading/(comm/mpi_.*|balance/zoltan_partitioner)\.cpp$|^tests/threading/.*\.cpp$")),
    ("OpenCASCADE", re.compile(r"\.hxx$"),
     re.compile(r"^core/cad/(.*\.cpp|.*_detail\.hpp|detail/.*)$|^examples/make_demo_model/|^tests/(cad|support)/")),
    ("OpenMesh", re.compile(r"^OpenMesh/"),
     re.compile(r"^core/discrete/(.*\.cpp|.*_detail\.hpp|detail/.*)$|^mesher/surface/facet_patch\.cpp$")),
    ("TetGen", re.compile(r"^tetgen\.h$"), re.compile(r"^apps/tetgen_worker/")),
    ("CLI11", re.compile(r"^CLI/"), re.compile(r"^(apps|examples)/|^bench/support/command_line\.cpp$")),
    ("nlohmann-json", re.compile(r"^nlohmann/"), re.compile(r"^(apps|bench|tests)/|\.cpp$")),
    ("Catch2", re.compile(r"^catch2/"), re.compile(r"^tests/")),
    ("Google Benchmark", re.compile(r"^benchmark/"), re.compile(r"^bench/")),
]

# Headers that only their own folder (and the tests) may include; those of an adapter may name the wrapped library.
PRIVATE_HEADER = re.compile(r"_detail\.hpp$|/detail/")

# Standard headers and the names in std that ask for them. Builds with precompiled headers do not see a missing one.
STANDARD = {
    "algorithm": "adjacent_find all_of any_of binary_search clamp copy copy_n copy_if count count_if equal equal_range "
                 "fill fill_n find find_if find_if_not for_each generate includes inplace_merge is_sorted "
                 "lexicographical_compare lower_bound max max_element merge min min_element minmax minmax_element "
                 "mismatch none_of nth_element partial_sort partition partition_point remove_if replace reverse rotate "
                 "set_difference set_intersection set_union shuffle sort stable_partition stable_sort swap_ranges "
                 "transform unique upper_bound",
    "array": "array", "atomic": "atomic atomic_flag atomic_ref memory_order_relaxed",
    "bit": "bit_cast bit_ceil bit_floor bit_width countl_zero countr_zero endian has_single_bit popcount",
    "charconv": "from_chars to_chars chars_format", "chrono": "chrono",
    "cmath": "abs acos asin atan atan2 cbrt ceil copysign cos exp fabs floor fma frexp hypot isfinite isnan ldexp log "
             "log10 log2 lround nan nextafter pow round sin sqrt tan trunc",
    "condition_variable": "condition_variable", "cstdio": "printf fprintf snprintf fopen fclose fflush",
    "cstdlib": "getenv strtod strtol exit abort", "cstring": "memchr memcmp memcpy memmove memset strcmp strlen",
    "deque": "deque", "exception": "current_exception exception exception_ptr rethrow_exception terminate",
    "filesystem": "filesystem", "fstream": "fstream ifstream ofstream",
    "functional": "function hash ref reference_wrapper cref", "future": "async future promise",
    "iterator": "back_inserter make_move_iterator istreambuf_iterator", "limits": "numeric_limits", "list": "list",
    "map": "map multimap", "memory": "make_shared make_unique shared_ptr unique_ptr weak_ptr",
    "mutex": "call_once lock_guard mutex once_flag recursive_mutex scoped_lock unique_lock",
    "numbers": "numbers", "numeric": "accumulate exclusive_scan gcd inclusive_scan iota midpoint partial_sum",
    "optional": "nullopt optional", "queue": "priority_queue queue",
    "random": "mt19937 mt19937_64 minstd_rand normal_distribution uniform_int_distribution uniform_real_distribution",
    "regex": "regex regex_match regex_search regex_replace", "set": "multiset set", "span": "span as_bytes",
    "sstream": "istringstream ostringstream stringstream", "stdexcept": "invalid_argument logic_error runtime_error",
    "string": "getline stod stoi stol stoul string to_string", "string_view": "string_view",
    "thread": "thread this_thread", "tuple": "make_tuple tie tuple", "typeinfo": "type_info",
    "type_traits": "conditional_t decay_t enable_if_t invoke_result_t is_invocable_v is_same_v remove_cvref_t",
    "unordered_map": "unordered_map", "unordered_set": "unordered_set", "variant": "get_if monostate variant visit",
    "vector": "vector",
}
HEADER_OF = {name: header for header, names in STANDARD.items() for name in names.split()}

# What else a header of the library or of others is sure to bring.
BRINGS = {
    "catch2/catch.hpp": {"string", "vector"}, "charconv": {"type_traits"}, "CLI/CLI.hpp": {"string", "vector"},
    "filesystem": {"string", "string_view"}, "fstream": {"string"}, "iostream": {"string"}, "map": {"tuple"},
    "nlohmann/json.hpp": {"map", "string", "vector"}, "regex": {"string"}, "span": {"array"}, "sstream": {"string"},
    "string": {"string_view"},
}

INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')
INCLUDED = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.M)


def source_files(root):
    listing = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", "*.cpp", "*.hpp", "*.h"],
        cwd=root, check=True, capture_output=True, text=True).stdout.split()
    return sorted(set(name for name in listing if (root / name).exists()))


def private_violation(name, header):
    folder = os.path.dirname(header).removesuffix("/detail")
    if name.startswith("tests/"):
        return None
    if not name.startswith(folder + "/"):
        return f"{header} is private to {folder}"
    if name.endswith(".hpp") and not PRIVATE_HEADER.search(name):
        return f"a public header may not include the private {header}"
    return None


def room_of(name):
    public = re.fullmatch(r"(?:include/)?tetloom/(\w+)\.hpp", name)
    if not public:
        return name.split("/")[0]
    return next((room for room, headers in PUBLIC.items() if public.group(1) in headers), "include")


def edge_violation(name, header):
    """Why `name` may not include `header`; None where it may."""
    if header.startswith("tetloom/") and room_of(header) == "include":
        return f"{header} is no public header of a known room"
    if name.startswith("include/") and "/" in header and not header.startswith("tetloom/"):
        return f"a public header may include public ones only, not {header}"
    room, target = room_of(name), room_of(header)
    folder, target_folder = os.path.dirname(name), os.path.dirname(header)
    allowed_folders = FOLDER_MAY_INCLUDE.get(folder)
    if allowed_folders is not None and target_folder in FOLDER_MAY_INCLUDE.keys() - allowed_folders - {folder}:
        return f"{folder} may not include {target_folder} ({header}): imports point downwards"
    if target in MAY_INCLUDE and "/" in header:
        if room in MAY_INCLUDE and target != room and target not in MAY_INCLUDE[room]:
            return f"{room} may not include {target} ({header}): imports point downwards"
        return private_violation(name, header) if PRIVATE_HEADER.search(header) else None
    for what, headers, allowed in ADAPTERS:
        if headers.search(header) and not allowed.search(name):
            return f"{what} ({header}) may not be included here, only in {allowed.pattern}"
    return None


def check_edges(root, names):
    problems = []
    for name in names:
        for number, line in enumerate((root / name).read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            reason = edge_violation(name, match.group(2))
            if reason is None and match.group(1) == '"' and not any(
                    (root / base / match.group(2)).exists() for base in ("", "include")):
                reason = f'"{match.group(2)}" is no path from the root of the checkout or include/'
            if reason:
                problems.append(f"{name}:{number}: {reason}")
    return problems


def own_path(root, header):
    """Where the header of an include of the project lies, or None for one of others."""
    return next((base + header for base in ("", "include/") if (root / (base + header)).is_file()), None)


CODE_ONLY = re.compile(r'//[^\n]*|"(?:\\.|[^"\\\n])*"|^\s*#\s*include[^\n]*', re.M)


def included_by(root, name, known):
    """The headers of others that `name` includes, by itself or through headers of the project."""
    if name not in known:
        known[name] = set()
        for line in (root / name).read_text(encoding="utf-8").splitlines():
            match = INCLUDE.match(line)
            header = match.group(2) if match else None
            own = own_path(root, header) if header else None
            if own:
                known[name] = known[name] | included_by(root, own, known)
            elif header:
                known[name] = known[name] | {header} | BRINGS.get(header, set())
    return known[name]


def check_standard_headers(root, names):
    """Names of the standard library whose header a file does not include."""
    problems, known = [], {}
    for name in names:
        code = CODE_ONLY.sub("", (root / name).read_text(encoding="utf-8"))
        used = {HEADER_OF[word] for word in re.findall(r"\bstd::(\w+)", code) if word in HEADER_OF}
        problems += [f"{name}: uses names of <{header}> and does not include it"
                     for header in sorted(used - included_by(root, name, known))]
    return problems


TYPE = re.compile(r"(?:template\s*<.*>\s*)?(?:struct|class|enum class)\s+(?:\w+\s+)?(?!final\b)(\w+)(?:\s+final)?\s*(?::[^:].*)?\{")


FUNCTION = re.compile(r"(?:inline |constexpr |template\s*<.*>\s*)*[A-Za-z_][\w:<>,&* ]*[ &*>]([a-z]\w*_\w+)\(")
CONSTANT = re.compile(r"(?:inline |static )?constexpr .*\b(k[A-Z]\w+)\s*[={\[]")


def declared_in(text):
    """Types, functions of several words and constants that a header declares outside of classes."""
    found = set()
    for line in text.splitlines():
        match = TYPE.match(line) or CONSTANT.match(line) or FUNCTION.match(line)
        if match:
            found.add(match.group(1))
    return found


def reached_from(root, name, known):
    """`name` and the headers of the project that it includes, by itself or through each other."""
    if name not in known:
        known[name] = {name}
        for line in (root / name).read_text(encoding="utf-8").splitlines():
            match = INCLUDE.match(line)
            own = own_path(root, match.group(2)) if match else None
            if own:
                known[name] = known[name] | reached_from(root, own, known)
    return known[name]


ENUMERATORS = re.compile(r"(\benum (?:class )?\w+[^{};]*)\{[^{}]*\}")
# What stands before a name that is declared, and is no type.
NO_TYPES = r"(?<!\breturn)(?<!\belse)(?<!\bthrow)(?<!\bnew)(?<!\bcase)(?<!\bnot)"


def declares(text, word):
    """Whether a file has a type, function, variable or member of that name of its own."""
    return re.search(rf"\b(?:class|struct|enum|using|typename) {word}\b|[\w>&*\]]{NO_TYPES}[ &*]+{word}\b *(?:[=;({{\[:,)]|$)|"
                     rf"[\[,] *{word} *[\],]", text, re.M)


def check_project_headers(root, names):
    """Names that one header of the project alone declares, in files that reach no header with that name. A source that
    is compiled in one piece with others would not show it."""
    texts = {name: ENUMERATORS.sub(r"\1", CODE_ONLY.sub("", (root / name).read_text(encoding="utf-8"))) for name in names}
    words_of = {name: set(re.findall(r"(?<![\w.>])(?<!::)(?:tetloom::|test::)?(\w+)", text)) for name, text in texts.items()}
    declaring = {}
    for name in names:
        if name.endswith(".hpp"):
            for word in declared_in(texts[name]):
                declaring.setdefault(word, set()).add(name)
    home = {word: next(iter(files)) for word, files in declaring.items() if len(files) == 1}
    problems, known = [], {}
    for name in names:
        room, others = room_of(name), reached_from(root, name, known) - {name}
        stems = {Path(header).stem for header in INCLUDED.findall((root / name).read_text(encoding="utf-8"))}
        for word in sorted(words_of[name] & home.keys()):
            declaring_room = room_of(home[word])
            if declaring_room != room and declaring_room not in MAY_INCLUDE.get(room, ()):
                continue
            if home[word] == name or word in stems or any(word in words_of[other] for other in others) or declares(texts[name], word):
                continue
            problems.append(f"{name}: uses {word} and does not include {home[word]}")
    return problems


def check_names(root, names):
    """Two headers or two sources of one name, and types of one name of which a header outside of a class has one."""
    problems, file_of, type_of = [], {}, {}
    names = [name for name in names if room_of(name) in ("core", "threading", "mesher", "adapt", "apps")]
    for name in names:
        base = os.path.basename(name)
        is_public = name.startswith("include/")
        if base != "main.cpp" and file_of.setdefault(base, name) != name:
            problems.append(f"{name}: {file_of[base]} has that name" + (" as a public header" if is_public else ""))
    for name in sorted(names, key=lambda name: name.endswith(".cpp")):
        for number, line in enumerate((root / name).read_text(encoding="utf-8").splitlines(), 1):
            match = TYPE.match(line)
            if not match:
                continue
            known = type_of.get(match.group(1))
            if known and known != name:
                problems.append(f"{name}:{number}: {known} has a type {match.group(1)}")
            elif name.endswith(".hpp"):
                type_of[match.group(1)] = name
    return problems


def flags_by_folder(build):
    """The compiler flags of one source of each folder, from compile_commands.json."""
    flags = {}
    for command in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(command["command"])
        keep = [word for word in words if word.startswith(("-I", "-D", "-std", "-f"))]
        keep += [part for i, word in enumerate(words) if word == "-isystem" for part in words[i:i + 2]]
        flags.setdefault(os.path.dirname(command["file"]), keep)
    return flags


def check_header_alone(root, name, flags):
    folder = str((root / name).parent)
    while folder not in flags and len(folder) > len(str(root)):
        folder = os.path.dirname(folder)
    command = ["g++", "-std=c++20", *flags.get(folder, []), "-I", str(root), "-I", str(root / "include"), "-fsyntax-only", "-x", "c++",
               "-include", str(root / name), "/dev/null"]
    result = subprocess.run(command, capture_output=True, text=True)
    return None if result.returncode == 0 else f"{name}: does not compile alone:\n{result.stderr[:2000]}"


def stands_first(root, header):
    """Whether the source of that name includes the header before anything else: its compilation is the proof then."""
    source = root / (header.removesuffix(".hpp") + ".cpp")
    if not source.exists():
        return False
    includes = (INCLUDE.match(line) for line in source.read_text(encoding="utf-8").splitlines())
    return next((match.group(2) for match in includes if match), None) == header


def check_headers(root, names, build):
    flags = flags_by_folder(build)
    headers = [name for name in names if name.endswith(".hpp") and not stands_first(root, name)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = pool.map(lambda name: check_header_alone(root, name, flags), headers)
    return [problem for problem in results if problem]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--headers", action="store_true", help="also compile alone every header that no source includes first")
    parser.add_argument("--build", default="build/release", help="build folder with compile_commands.json")
    arguments = parser.parse_args()
    root = Path(__file__).resolve().parent.parent
    names = source_files(root)
    problems = check_edges(root, names) + check_names(root, names) + check_standard_headers(root, names) + \
        check_project_headers(root, names)
    if arguments.headers:
        problems += check_headers(root, names, root / arguments.build)
    for problem in problems:
        print(problem)
    if problems:
        sys.exit(1)
    print(f"{len(names)} files: imports point downwards, names are their own" + (" and every header compiles alone." if arguments.headers
                                                            else "."))


if __name__ == "__main__":
    main()
