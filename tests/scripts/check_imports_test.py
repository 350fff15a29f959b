"""Which edges scripts/check_imports.py lets pass, and which it names."""
import importlib.util
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPEC = importlib.util.spec_from_file_location("check_imports", ROOT / "scripts" / "check_imports.py")
check_imports = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(check_imports)


def problems_of(check, files):
    """What a check says of files with these texts."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, text in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)
        return check(root, sorted(files))


class Rooms(unittest.TestCase):
    def assert_refused(self, name, header):
        self.assertIn("may not include", check_imports.edge_violation(name, header) or "", f"{name} -> {header}")

    def assert_allowed(self, name, header):
        self.assertIsNone(check_imports.edge_violation(name, header), f"{name} -> {header}")

    def test_adaptation_and_mesher_stand_side_by_side(self):
        self.assert_refused("adapt/kernel/swap.cpp", "mesher/tets/edge_removal.hpp")
        self.assert_refused("mesher/tets/optimizer.cpp", "adapt/kernel/cavity_mesh.hpp")
        self.assert_refused("adapt/adapter.cpp", "tetloom/mesh.hpp")
        self.assert_refused("mesher/make_mesh.cpp", "tetloom/adapt.hpp")
        self.assert_refused("include/tetloom/adapt.hpp", "tetloom/mesh.hpp")

    def test_both_stand_on_core_and_threading(self):
        for room in ("adapt", "mesher"):
            self.assert_allowed(f"{room}/any.cpp", "core/tets/tet_mesh.hpp")
            self.assert_allowed(f"{room}/any.cpp", "tetloom/tasks.hpp")

    def test_core_knows_nothing_of_what_stands_on_it(self):
        for header in ("threading/shared_work.hpp", "tetloom/tasks.hpp", "mesher/tets/recovery.hpp",
                       "adapt/metric/tet_edges.hpp"):
            self.assert_refused("core/tets/link_tets.cpp", header)

    def test_an_edge_is_named_with_its_file_and_line(self):
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for name, text in (("adapt/a.cpp", '#pragma once\n#include "mesher/b.hpp"\n'), ("mesher/b.hpp", "")):
                (root / name).parent.mkdir()
                (root / name).write_text(text)
            problems = check_imports.check_edges(root, ["adapt/a.cpp", "mesher/b.hpp"])
        self.assertEqual(len(problems), 1)
        self.assertTrue(problems[0].startswith("adapt/a.cpp:2: adapt may not include mesher"), problems[0])


class StandardHeaders(unittest.TestCase):
    def problems_of(self, files):
        return problems_of(check_imports.check_standard_headers, files)

    def test_a_name_whose_header_is_missing_is_told(self):
        problems = self.problems_of({"core/a.cpp": "#include <string>\nstd::vector<int> all;\n"})
        self.assertEqual(problems, ["core/a.cpp: uses names of <vector> and does not include it"])

    def test_a_header_of_the_project_may_bring_it(self):
        self.assertEqual(self.problems_of({"core/a.hpp": "#include <vector>\nstd::vector<int> all();\n",
                                           "core/a.cpp": '#include "core/a.hpp"\nstd::vector<int> mine;\n'}), [])

    def test_names_in_comments_and_texts_ask_for_nothing(self):
        self.assertEqual(self.problems_of({"core/a.cpp": '// std::vector\nauto text = "std::map";\n'}), [])


class ProjectHeaders(unittest.TestCase):
    files = {"core/shape.hpp": "struct Shape {\n};\nShape shape_at(int);\nconstexpr int kShapes = 3;\n",
             "core/user.hpp": '#include "core/shape.hpp"\nShape used();\n'}

    def problems_of(self, source):
        return problems_of(check_imports.check_project_headers, {**self.files, "core/a.cpp": source})

    def test_a_type_a_function_and_a_constant_ask_for_their_header(self):
        for use in ("Shape made;", "auto made = shape_at(1);", "int i = kShapes;"):
            self.assertEqual(len(self.problems_of(use + "\n")), 1, use)
            self.assertEqual(self.problems_of('#include "core/shape.hpp"\n' + use + "\n"), [])

    def test_another_header_may_bring_it(self):
        self.assertEqual(self.problems_of('#include "core/user.hpp"\nShape made;\n'), [])

    def test_own_names_members_and_those_of_others_ask_for_nothing(self):
        for text in ("struct Shape { int i; };", "class Shape;", "enum class Kind { Shape, Other };", "int kShapes = 1;",
                     "int i = object.shape_at(1);", "#include <Shape.hxx>\nShape made;", "// Shape"):
            self.assertEqual(self.problems_of(text + "\n"), [], text)


class Names(unittest.TestCase):
    def problems_of(self, files):
        return problems_of(check_imports.check_names, files)

    def test_two_headers_of_one_name_are_refused(self):
        problems = self.problems_of({"adapt/a/patch.hpp": "", "mesher/b/patch.hpp": "", "mesher/b/patch.cpp": ""})
        self.assertEqual(problems, ["mesher/b/patch.hpp: adapt/a/patch.hpp has that name"])

    def test_a_type_of_a_header_has_a_name_of_its_own(self):
        header = "struct Cavity {\n"
        self.assertEqual(self.problems_of({"adapt/a.hpp": header, "mesher/b.hpp": header}),
                         ["mesher/b.hpp:1: adapt/a.hpp has a type Cavity"])
        self.assertEqual(self.problems_of({"core/a.hpp": header, "core/b.cpp": "\nclass Cavity final : public B {\n"}),
                         ["core/b.cpp:2: core/a.hpp has a type Cavity"])

    def test_nested_types_declarations_and_those_of_two_sources_may_share_a_name(self):
        self.assertEqual(self.problems_of({"core/a.hpp": "struct Slot {\n", "core/b.hpp": "  struct Slot {\nstruct Slot;\n",
                                           "core/c.cpp": "struct Own {\n", "core/d.cpp": "struct Own {\n"}), [])


if __name__ == "__main__":
    unittest.main()
