#include "io/yaml.h"

#include <gmock/gmock.h>

namespace stillpoint::io {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

struct Inner {
  double rate_hz = 100.0;
  int depth = 3;
  static constexpr auto fields() {
    return std::tuple{field("rate_hz", &Inner::rate_hz, in_range(1, 4000), "samples per second"),
                      field("depth", &Inner::depth, in_range(1, 10), "how deep")};
  }
};

struct Outer {
  Inner inner;
  Vec3 axis = Vec3::UnitX();
  Mat3 matrix = Mat3::Identity();
  bool on = false;
  std::string name = "none";
  static constexpr auto fields() {
    return std::tuple{field("inner", &Outer::inner, "a group"), field("axis", &Outer::axis, "x, y, z"),
                      field("matrix", &Outer::matrix, "rows"), field("on", &Outer::on, "switch"),
                      field("name", &Outer::name, "text")};
  }
};

/// The faults that reading `text` into an Outer gives; `out` keeps what was read.
std::vector<std::string> faults_of(const std::string& text, Outer& out) {
  YamlFaults faults("f.yaml");
  const auto root = parse_yaml(text, "f.yaml");
  if (!root) return {root.error().message};
  read_fields(*root, out, faults);
  return faults.messages();
}

TEST(Yaml, ReadsEveryKindOfFieldAndKeepsDefaultsForTheRest) {
  Outer out;
  EXPECT_THAT(faults_of("inner: {rate_hz: 250}\naxis: [1, 2, 3]\nmatrix: [[1,2,3],[4,5,6],[7,8,9]]\non: true\n", out),
              ElementsAre());
  EXPECT_EQ(out.inner.rate_hz, 250);
  EXPECT_EQ(out.inner.depth, 3);
  EXPECT_EQ(out.axis, Vec3(1, 2, 3));
  EXPECT_EQ(out.matrix(1, 2), 6);
  EXPECT_TRUE(out.on);
  EXPECT_EQ(out.name, "none");
}

TEST(Yaml, ReportsAllFaultsAtOnceEachWithItsPlace) {
  Outer out;
  const auto faults = faults_of("inner:\n  rate_hs: 5\n  depth: 2.5\naxis: [1, x, 3]\non: maybe\n", out);
  EXPECT_THAT(faults,
              ElementsAre("f.yaml:2:3: unknown key 'rate_hs'; did you mean 'rate_hz'?",
                          "f.yaml:3:10: 'depth' must be a whole number, not 2.5",
                          "f.yaml:4:11: 'axis' must be a number, not 'x'", "f.yaml:5:5: 'on' must be true or false"));
  EXPECT_EQ(out.axis, Vec3::UnitX()) << "a faulty value leaves the default";
}

TEST(Yaml, RefusesWhatIsOutOfRangeOrNotANumber) {
  Outer out;
  EXPECT_THAT(faults_of("inner: {rate_hz: 5000}\n", out),
              ElementsAre(HasSubstr("f.yaml:1:18: 'rate_hz' is 5000, allowed is 1 to 4000")));
  EXPECT_THAT(faults_of("inner: {rate_hz: .nan}\n", out), ElementsAre(HasSubstr("must be a finite number")));
}

TEST(Yaml, RefusesARepeatedKey) {
  Outer out;
  EXPECT_THAT(faults_of("on: true\non: false\n", out), ElementsAre(HasSubstr("f.yaml:2:1: key 'on' stands twice")));
}

TEST(Yaml, RefusesAnAliasWhichCouldContainItself) {
  EXPECT_THAT(parse_yaml("a: &x [1, *x]\n", "f.yaml").error().message,
              HasSubstr("f.yaml:1:11: not valid YAML: aliases"));
}

TEST(Yaml, SaysWhereTheSyntaxBreaks) {
  EXPECT_THAT(parse_yaml("a: [1, 2\nb: 3\n", "f.yaml").error().message, HasSubstr("not valid YAML"));
  EXPECT_THAT(parse_yaml("a:\n\tb: 3\n", "f.yaml").error().message,
              AllOf(HasSubstr("f.yaml:2:"), HasSubstr("indent with spaces, not tabs")));
  EXPECT_THAT(parse_yaml("a: \"\\\x01\"\n", "f.yaml").error().message, Not(HasSubstr("\x01")));
  EXPECT_EQ(load_yaml("/nowhere/f.yaml").error().kind, ErrorKind::kNoInput);
}

TEST(Yaml, ATextIsWrittenSoThatItReadsBackToTheSameBytes) {
  EXPECT_EQ(yaml_text("it's"), "'it''s'");
  std::string ascii;
  for (char c = 0; c >= 0 && c < 0x7f; ++c) ascii += c;
  for (const std::string& text : {std::string("plain"), std::string(), std::string("two\nlines \"\\' and\ttabs\r"),
                                  std::string("\xc2\xb5T"), ascii + '\x7f'})
    EXPECT_EQ(YAML::Load("a: " + yaml_text(text))["a"].as<std::string>(), text) << yaml_text(text);
}

}  // namespace
}  // namespace stillpoint::io
