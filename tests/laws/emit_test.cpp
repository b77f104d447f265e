/// Emitted code is compiled or run, and compared with our own evaluation on the same drivers.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>

#include "laws/emit.h"
#include "laws/evaluate.h"

namespace stillpoint::laws {
namespace {

namespace fs = std::filesystem;

constexpr int kRows = 120;

Columns drivers() {
  Columns c;
  c.t_s.resize(kRows);
  for (const char* name : {"w", "f", "T", "I"}) c.values[name].resize(kRows, name[0] >= 'a' ? 3 : 1);
  for (int i = 0; i < kRows; ++i) {
    const double t = 0.05 * i + 0.004 * std::sin(1.7 * i);  // an uneven clock
    c.t_s[i] = 3.0 + t;
    c.values["w"].row(i) << std::sin(t), 0.3 - std::cos(2.0 * t), 0.7 * std::sin(3.0 * t);
    c.values["f"].row(i) << 1.0 + std::cos(t), -2.0, 9.0 + std::sin(0.4 * t);
    c.values["T"](i, 0) = 24.0 + 0.3 * t;
    c.values["I"](i, 0) = i % 30 < 12 ? 2.0 : 0.1;
  }
  return c;
}

std::vector<Coupled> laws() {
  const auto law = [](const char* text, std::array<double, 9> numbers, bool matrix) {
    Coupled out;
    auto tree = parse(text, standard_drivers());
    EXPECT_TRUE(tree) << text;
    if (tree) out.tree = *tree;
    out.matrix = numbers;
    out.has_matrix = matrix;
    out.sensor = "gyroscope";
    out.unit = "rad/s";
    return out;
  };
  const std::array<double, 9> k{0.5, -1.25, 2.0}, m{0.1, 0.2, -0.3, 0.4, 0.5, 0.6, -0.7, 0.8, 0.9};
  std::vector<Coupled> out{law("norm(w) * (T - 25)", k, false),
                           law("f * (T - 24.5) / 3", m, true),
                           law("lag(I, 1.3) * sign(w_x)", k, false),
                           law("cross(d(w), f)", k, false),
                           law("play(w, 0.4) * abs(w) - w^2 / 3 * 2^3", k, false),
                           law("integral(I) * step(t, 2) + delay(I, 0.31) * t", k, false),
                           law("exp(-t / 3) * sin(f / 0.7) + cos(w / 2) * log(1 + t / 5) + tanh(w / 0.4)", m, true),
                           law("d(T) * (-w_y)", k, false)};
  std::erase_if(out, [](const Coupled& c) { return c.tree.args.empty(); });
  out[0].from_s = 1.0;
  out[0].to_s = 4.0;
  // Tables of a number and of a vector, which leave the points at both ends.
  for (const std::size_t of : {0U, 4U}) {
    out.push_back(out[of]);
    out.back().table =
        Table{{-0.5, 0.1, 0.4}, {{{1, 2, 5}, {0, -1, 3}, {4, 4, 0}}}, {{{3, 2, 6}, {0, 1, 9}, {0, -7, -20}}}};
  }
  return out;
}

/// Of the cubic a + b d + c d^2 + e d^3 from the point before.
double through(const Table& table, std::size_t axis, double at) {
  const std::vector<double>&x = table.x, &y = table.y[axis], &slope = table.slope[axis];
  at = std::clamp(at, x.front(), x.back());
  const std::size_t k = at < x[1] ? 0 : 1;
  const double h = x[k + 1] - x[k], d = at - x[k], secant = (y[k + 1] - y[k]) / h;
  const double c = (3.0 * secant - 2.0 * slope[k] - slope[k + 1]) / h;
  return y[k] + d * (slope[k] + d * (c + d * (slope[k] + slope[k + 1] - 2.0 * secant) / (h * h)));
}

Eigen::MatrixXd expected(const Coupled& law, const Columns& c) {
  const Eigen::MatrixXd x = evaluate(law.tree, c);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(kRows, 3);
  for (int i = 0; i < kRows; ++i) {
    const double t = c.t_s[i] - c.t_s[0];
    if (law.to_s > law.from_s && (t < law.from_s || t > law.to_s)) continue;
    for (int r = 0; r < 3; ++r) {
      const auto at = static_cast<std::size_t>(r);
      if (law.table)
        out(i, r) = through(*law.table, at, x(i, x.cols() == 1 ? 0 : r));
      else if (!law.has_matrix)
        out(i, r) = law.matrix[at] * x(i, x.cols() == 1 ? 0 : r);
      else
        for (int j = 0; j < 3; ++j) out(i, r) += law.matrix[3 * at + static_cast<std::size_t>(j)] * x(i, j);
    }
  }
  return out;
}

class Emit : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("stillpoint_emit_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    write_drivers();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write_drivers() {
    std::ofstream out(folder_ / "drivers.txt");
    out << std::setprecision(17);
    const Columns c = drivers();
    for (int i = 0; i < kRows; ++i)
      out << c.t_s[i] << ' ' << c.values.at("w").row(i) << ' ' << c.values.at("f").row(i) << ' '
          << c.values.at("T")(i, 0) << ' ' << c.values.at("I")(i, 0) << '\n';
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  /// Runs a command in the folder; its file out.txt holds kRows x 3 numbers a law.
  void compare(const std::string& command) {
    const std::string whole = "cd '" + folder_.string() + "' && " + command + " > log.txt 2>&1";
    ASSERT_EQ(std::system(whole.c_str()), 0) << [&] {
      std::ifstream log(folder_ / "log.txt");
      return std::string(std::istreambuf_iterator<char>(log), {});
    }();
    std::ifstream in(folder_ / "out.txt");
    for (const Coupled& law : laws()) {
      const Eigen::MatrixXd want = expected(law, drivers());
      double worst = 0.0;
      for (int i = 0; i < kRows; ++i)
        for (int r = 0; r < 3; ++r) {
          double got = NAN;
          in >> got;
          worst = std::max(worst, std::isfinite(got) ? std::abs(got - want(i, r)) : 1e9);
        }
      EXPECT_LT(worst, 1e-9) << text(law.tree);
    }
  }
  static std::string arguments(const Coupled& law) {
    std::string out = "t";
    for (const std::string& d : drivers_of(law.tree))
      if (d != "t") out += ", " + d;
    return out;
  }
  static bool there(const char* program) {
    return std::system((std::string("command -v ") + program + " > /dev/null 2>&1").c_str()) == 0;
  }
  fs::path folder_;
};

/// A law that was found beside a wrong matrix is another number without it.
TEST_F(Emit, TheCommentSaysWhatTheLawWasFoundBeside) {
  Coupled law = laws().front();
  law.beside = {"it reads M (truth + this) + b", "M = [[0.95, 0, 0]]"};
  for (const Language l : {Language::kPython, Language::kCpp, Language::kMatlab})
    for (const std::string& line : law.beside) EXPECT_NE(emit(law, "law_1", l).find(line), std::string::npos) << line;
}

TEST_F(Emit, PythonGivesTheSame) {
  if (!there("python3")) GTEST_SKIP() << "LOUD: SKIPPED: no python3 here";
  std::string main =
      "rows = [[float(x) for x in l.split()] for l in open('drivers.txt')]\nt = [r[0] for r in rows]\n"
      "w = [r[1:4] for r in rows]\nf = [r[4:7] for r in rows]\nT = [r[7] for r in rows]\nI = [r[8] for r in rows]\n"
      "out = open('out.txt', 'w')\n";
  int k = 0;
  for (const Coupled& law : laws()) {
    const std::string name = "law" + std::to_string(++k);
    write(name + ".py", emit(law, name, Language::kPython));
    main += "from " + name + " import " + name + "\nfor r in " + name + "(" + arguments(law) +
            "):\n    print(*['%.17g' % c for c in r], file=out)\n";
  }
  write("main.py", main);
  compare("python3 main.py");
}

TEST_F(Emit, CppGivesTheSame) {
  if (!there("g++")) GTEST_SKIP() << "LOUD: SKIPPED: no g++ here";
  std::string includes = "#include <fstream>\n#include <iomanip>\n", calls;
  int k = 0;
  for (const Coupled& law : laws()) {
    const std::string name = "law" + std::to_string(++k);
    write(name + ".h", emit(law, name, Language::kCpp));
    includes += "#include \"" + name + ".h\"\n";
    calls += "  for (const auto& r : " + name + "(" + arguments(law) +
             ")) out << r[0] << ' ' << r[1] << ' ' << r[2] << '\\n';\n";
  }
  write("main.cpp", includes +
                        "int main() {\n  std::ifstream in(\"drivers.txt\");\n  std::vector<double> t, T, I;\n"
                        "  std::vector<std::array<double, 3>> w, f;\n  double x[9];\n"
                        "  while (in >> x[0] >> x[1] >> x[2] >> x[3] >> x[4] >> x[5] >> x[6] >> x[7] >> x[8]) {\n"
                        "    t.push_back(x[0]), w.push_back({x[1], x[2], x[3]}), f.push_back({x[4], x[5], x[6]}),\n"
                        "        T.push_back(x[7]), I.push_back(x[8]);\n  }\n"
                        "  std::ofstream out(\"out.txt\");\n  out << std::setprecision(17);\n" +
                        calls + "}\n");
  compare("g++ -std=c++17 -Wall -Wextra -Werror main.cpp -o main && ./main");
}

TEST_F(Emit, MatlabGivesTheSame) {
  if (!there("octave-cli")) GTEST_SKIP() << "LOUD: SKIPPED: no octave-cli here";
  std::string main =
      "d = load('drivers.txt');\nt = d(:, 1); w = d(:, 2:4); f = d(:, 5:7); T = d(:, 8); I = d(:, 9);\n"
      "out = fopen('out.txt', 'w');\n";
  int k = 0;
  for (const Coupled& law : laws()) {
    const std::string name = "law" + std::to_string(++k);
    write(name + ".m", emit(law, name, Language::kMatlab));
    main += "fprintf(out, '%.17g %.17g %.17g\\n', " + name + "(" + arguments(law) + ")');\n";
  }
  write("run_all.m", main + "fclose(out);\n");
  compare("octave-cli --no-gui run_all.m");
}

}  // namespace
}  // namespace stillpoint::laws
