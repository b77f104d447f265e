#!/usr/bin/env python3
"""The mutants of scripts/mutation.py are those meant, and nothing else is touched: mutation_test.py SOURCE"""
import pathlib
import re
import sys
import unittest

SOURCE = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(SOURCE / "scripts"))
import mutants
import mutation


def made(line, operator=None):
    return [m.after for m in mutation.mutants_of("a.cpp", line) if operator in (None, m.operator)]


class Mutation(unittest.TestCase):
    def test_each_operator_makes_its_one_change(self):
        for operator, line, wanted in [
                ("sign", "x = a + b;", ["x = a - b;"]),
                ("sign", "x -= a;", ["x += a;"]),
                ("sign", "return -a;", ["return a;"]),
                ("sign", "f(-a, -b);", ["f(a, -b);", "f(-a, b);"]),
                ("bound", "if (a < b) f();", ["if (a >= b) f();"]),
                ("bound", "if (n <= 3) f();", ["if (n > 3) f();", "if (n < 3) f();"]),
                ("bound", "if (a == b) f();", ["if (a != b) f();"]),
                ("logic", "if (a && !b) f();", ["if (a || !b) f();", "if (a && b) f();"]),
                ("index", "x = v[2] * P(0, 1);", ["x = v[0] * P(0, 1);", "x = v[2] * P(1, 0);"]),
                ("index", "x = v.y();", ["x = v.z();"]),
                ("constant", "x = 0.5 * 1e-9;", ["x = (2 * 0.5) * 1e-9;", "x = 0.5 * (2 * 1e-9);"]),
                ("constant", "x = 0.0;", ["x = 1.0;"]),
                ("statement", "  x += f(a);", ["  {}"]),
                ("statement", "  ++counts_.lost;", ["  {}"])]:
            self.assertEqual(made(line, operator), wanted, line)

    def test_what_is_no_code_of_an_algorithm_has_no_mutant(self):
        for text in ["// a + b < 3", "/* a + b\n   c + d */", 'throw Error("a + b < 3");', "#include <array>", "using A = std::array<double, 3>;",
                     "static_assert(a < 3);", "struct A { std::array<B<int, 3>, 4> x; };", "p->f;", "char c = '+';",
                     'static constexpr auto fields() {\n  return std::tuple{field("a", &P::a, in_range(0.5, 3.0), "b + c")};\n}']:
            self.assertEqual(made(text), [], text)

    def test_what_would_not_compile_anyway_is_no_dropped_statement(self):
        for line in ["const double x = f(a);", "Vec3 x = f(a);", "return f(a);", "std::vector<int> x(3);", "auto& x = f(a);",
                     "void f(int a);", "f(a,", "break;", "class A;"]:
            self.assertEqual(made(line, "statement"), [], line)
        self.assertEqual(made("x =\n    f(a);", "statement"), [], "the second half of a statement")

    def test_one_mutant_changes_one_line_and_names_where(self):
        text = "a = b;\n  c = d + e;\nf();\n"
        [m] = [m for m in mutation.mutants_of("io/a.cpp", text) if m.operator == "sign"]
        self.assertEqual((m.id, m.key), ("io/a.cpp:2:9 sign", ("io/a.cpp", "c = d + e;", "c = d - e;")))
        self.assertEqual(mutation.applied(text, m), "a = b;\n  c = d - e;\nf();\n")
        with self.assertRaises(ValueError):
            mutation.applied("\n" + text, m)

    def test_the_interval_is_wilsons(self):
        for part, whole, low, high in [(0, 10, 0.0, 0.2775), (10, 10, 0.7225, 1.0), (50, 100, 0.4038, 0.5962)]:
            for told, wanted in zip(mutants.wilson(part, whole), (low, high)):
                self.assertAlmostEqual(told, wanted, places=3)

    def test_a_seed_draws_the_same_mutants_again(self):
        pool = mutants.mutants(["compensation"])["compensation"]
        paths = {m.path for m in pool}
        self.assertIn("pipeline/compensate_stage.cpp", paths)
        self.assertNotIn("pipeline/guard_stage.cpp", paths)
        first = mutants.draw(pool, 20, 7)
        self.assertEqual(len(set(first)), 20)
        self.assertEqual(first, mutants.draw(pool, 20, 7))
        self.assertNotEqual(first, mutants.draw(pool, 20, 8))
        self.assertEqual(mutants.draw(pool, 10**6, 7), pool)

    def test_every_module_has_files_and_a_test_program(self):
        for name, (pattern, targets) in mutants.MODULES.items():
            self.assertTrue([p for p in mutants.sources() if re.match(pattern, p)], name)
            for target in targets:
                program, _, chosen = target.partition(":")
                tests = [t.read_text() for t in (SOURCE / "tests" / program.removeprefix("test_")).glob("*_test.cpp")]
                self.assertTrue(tests, target)
                self.assertTrue(any(chosen.strip("*") in text for text in tests), target)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "--verbose"])
