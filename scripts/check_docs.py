#!/usr/bin/env python3
"""Checks that the documents agree with the code.

usage: scripts/check_docs.py [--command TETLOOM] [--every-file]
  --command      also compares docs/reference.md with what this tetloom says of its options
  --every-file   also names the files of which their folder's README says nothing

Checked: links lead to files; a folder's README names only what there is; lines have at most 120 characters, but for tables;
README.md and decisions stay short; types of public headers explain themselves or are in the glossary; the
drawings are those of draw_architecture.py; the reference has every member of a report. What is wrong is named as
"file:line: ...". Exit status 1 if there is any.
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import draw_architecture  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
MOST_LINES = {"README.md": 150}
MOST_LINES_OF_DECISION = 45
MOST_CHARACTERS = 120
SOURCES = (".cpp", ".hpp", ".py", ".sh", ".edp", ".cmake")
# Names of files that others write, and of what others have.
FOREIGN = re.compile(r"^(X|OUT|F|R|FILE|part\d*|flow|next|cube|fine|metric|assembly|scan|surface|sizes|report)\b")


def tracked_files():
    listing = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                             capture_output=True, text=True).stdout.split()
    return sorted(name for name in set(listing) if (ROOT / name).is_file())


def lines_of(name):
    return (ROOT / name).read_text(encoding="utf-8").splitlines()


def prose_lines(name):
    """Numbered lines outside of fences."""
    inside = False
    for number, line in enumerate(lines_of(name), 1):
        if line.lstrip().startswith("```"):
            inside = not inside
        elif not inside:
            yield number, line


def check_shape(name):
    lines = lines_of(name)
    most = MOST_LINES_OF_DECISION if re.match(r"docs/decisions/\d", name) else MOST_LINES.get(name)
    if most and len(lines) > most:
        yield f"{name}:{most}: more than {most} lines"
    for number, line in prose_lines(name):
        if len(line) > MOST_CHARACTERS and not line.lstrip().startswith(("|", "!")):
            yield f"{name}:{number}: a line of {len(line)} characters"


def check_links(name):
    for number, line in prose_lines(name):
        for target in re.findall(r"\]\(([^)\s]+)\)", line):
            path = target.split("#")[0]
            if path and "://" not in path and not (ROOT / name).parent.joinpath(path).exists():
                yield f"{name}:{number}: a link to {target}, which is not there"


class Names:
    """Everything that a README may name: files, folders, and words of the sources."""

    def __init__(self, files):
        self.files = files
        self.stems = {Path(name).stem for name in files}
        self.paths = set(files) | {str(parent) for name in files for parent in Path(name).parents}
        self.text = "\n".join((ROOT / name).read_text(encoding="utf-8", errors="replace") for name in files
                              if name.endswith(SOURCES + (".txt", ".json", ".in", "run")))
        self.words = set(re.findall(r"\w+", self.text))

    def has_path(self, text, folder):
        text = text.rstrip("/").removesuffix(".*")
        places = {text, f"{folder}/{text}", f"include/{text}"}
        if places & self.paths or any(path.endswith("/" + text) for path in self.paths):
            return True
        return any(path.rsplit(".", 1)[0] in places for path in self.files)

    def has(self, text, folder):
        if self.has_path(text, folder) or text in self.stems:
            return True
        if "/" in text or re.search(r"\.(cpp|hpp|py|sh|md)$", text):
            return f'"{text}"' in self.text
        return all(word in self.words for word in re.findall(r"\w+", text))


def is_name(text):
    """Whether it names a file, a folder, a type, a function or an option, and no file of a user."""
    return re.fullmatch(r"[\w./:*-]+(\(\))?", text) and not FOREIGN.match(text) and not re.fullmatch(r"[.\d:×%-]+", text) \
        and not text.startswith((".", "--", "build/"))


def check_names(name, names):
    folder = str(Path(name).parent)
    for number, line in prose_lines(name):
        for text in re.findall(r"`([^`]+)`", line):
            if is_name(text) and not names.has(text.removesuffix("()"), folder):
                yield f"{name}:{number}: names `{text}`, which is not there"


def check_coverage(name, files):
    """Each source of the folder is named in its README; `patch` stands for patch_rim.cpp and patch_detail.hpp as well."""
    folder = str(Path(name).parent)
    text = (ROOT / name).read_text(encoding="utf-8")
    stems = {Path(file).name.split(".")[0] for file in files
             if str(Path(file).parent) == folder and file.endswith((".cpp", ".hpp", ".py", ".sh", ".edp"))}
    named = {stem for stem in stems if re.search(rf"\b{re.escape(stem)}\b", text)}
    for stem in sorted(stems - named):
        if not any(stem.startswith(other.removesuffix("_detail")) for other in named):
            yield f"{name}:1: says nothing of {stem}"


def undocumented_types(name):
    """Types without a doc comment, as (line, name)."""
    lines = lines_of(name)
    for i, line in enumerate(lines):
        match = re.match(r"\s*(?:class|struct|enum class)\s+(\w+)\b(?!.*;\s*$)", line) or \
            re.match(r"\s*(?:class|struct|enum class)\s+(\w+)\s.*\{.*\};", line) or re.match(r"using\s+(\w+)\s*=", line)
        if not match:
            continue
        above = i - 1
        while above >= 0 and lines[above].lstrip().startswith(("template", "requires")):
            above -= 1
        if not lines[above].lstrip().startswith("///") and "///" not in line:
            yield i + 1, match.group(1)


def check_types(files):
    glossary = (ROOT / "docs/glossary.md").read_text(encoding="utf-8")
    for name in files:
        if not re.fullmatch(r"include/tetloom/\w+\.hpp", name):
            continue
        for number, type_name in undocumented_types(name):
            if f"`{type_name}`" not in glossary:
                yield f"{name}:{number}: {type_name} has no doc comment and is not in the glossary"


def check_drawings():
    for name, text in draw_architecture.drawings().items():
        path = ROOT / "docs/images" / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            yield f"docs/images/{name}:1: is not what scripts/draw_architecture.py draws"


def check_report_fields(files):
    """Every member of a report that apps/tetloom writes is in docs/reference.md."""
    known = {word for _, line in prose_lines("docs/reference.md") for text in re.findall(r"`([^`]+)`", line)
             for word in re.findall(r"\w+", text)}
    for name in files:
        if not re.fullmatch(r"apps/tetloom/\w+\.cpp", name):
            continue
        for number, line in enumerate(lines_of(name), 1):
            for member in re.findall(r'\{"(\w+)",(?!\s*")', line) + re.findall(r'(?:json|extra)\["(\w+)"\]', line):
                if member not in known:
                    yield f"{name}:{number}: docs/reference.md says nothing of the member {member}"


def check_reference(command):
    reference = (ROOT / "docs/reference.md").read_text(encoding="utf-8")
    known = set()
    for words in (["--help"], *([name, "--help"] for name in ("mesh", "info", "check", "partition", "adapt"))):
        text = subprocess.run([command, *words], check=True, capture_output=True, text=True).stdout
        options = set(re.findall(r"^\s+(?:-\w,\s*)?(--[\w-]+)", text, re.M))
        known |= options
        for option in sorted(options):
            if not re.search(rf"`[^`]*{option}\b", reference):
                yield f"docs/reference.md:1: says nothing of {option} of tetloom {' '.join(words[:-1])}"
    of_others = {"--mca", "--bind-to"}
    for option in sorted(set(re.findall(r"(--[a-z][\w-]+)", reference)) - known - of_others):
        yield f"docs/reference.md:1: names {option}, which tetloom does not know"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--command", help="a tetloom to compare docs/reference.md with")
    parser.add_argument("--every-file", action="store_true", help="also what READMEs leave out")
    arguments = parser.parse_args()
    files = tracked_files()
    names = Names(files)
    documents = [name for name in files if name.endswith(".md")]
    problems = [*check_types(files), *check_drawings(), *check_report_fields(files)]
    for name in documents:
        problems += check_shape(name)
        problems += check_links(name)
        if name.endswith("README.md") or name == "docs/architecture.md":
            problems += check_names(name, names)
        if arguments.every_file and name.endswith("/README.md"):
            problems += check_coverage(name, files)
    if arguments.command:
        problems += check_reference(arguments.command)
    for problem in problems:
        print(problem)
    if problems:
        sys.exit(1)
    print(f"{len(documents)} documents agree with the code.")


if __name__ == "__main__":
    main()
