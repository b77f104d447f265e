#include "report/document.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/embedded.h"

namespace stillpoint::report {
namespace {

const char* variable(Colour c) {
  switch (c) {
    case Colour::kBefore:
      return "--before";
    case Colour::kAfter:
      return "--after";
    case Colour::kNoise:
      return "--noise";
    case Colour::kAccent:
      return "--accent";
  }
  return "--ink";
}

const char* word(Mark m) {
  switch (m) {
    case Mark::kLine:
      return "line";
    case Mark::kBold:
      return "bold";
    case Mark::kDashed:
      return "dashed";
    case Mark::kDots:
      return "dots";
  }
  return "line";
}

/// Six digits: no eye sees more in a plot, and the page is half as large.
nlohmann::json drawn(const std::vector<double>& values) {
  auto out = nlohmann::json::array();
  for (const double x : values) {
    const double size = std::pow(10.0, 5.0 - std::floor(std::log10(std::abs(x))));
    out.push_back(std::isnormal(size) && std::isfinite(x) ? std::round(x * size) / size : x);
  }
  return out;
}

nlohmann::json to_json(const Plot& p) {
  auto curves = nlohmann::json::array();
  for (const Curve& c : p.curves)
    curves.push_back({{"label", c.label}, {"colour", variable(c.colour)}, {"mark", word(c.mark)}, {"y", drawn(c.y)}});
  return {{"id", p.id},           {"x", drawn(p.x)},  {"x_label", p.x_label},
          {"y_label", p.y_label}, {"curves", curves}, {"shaded", std::vector<int>(p.shaded.begin(), p.shaded.end())},
          {"log_x", p.log_x},     {"log_y", p.log_y}};
}

/// "</script>" or "<!--" inside a string would change where the element ends. Outside of its strings JSON has no '<'.
std::string inside_script(const std::string& json) {
  std::string out;
  for (const char c : json) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string figure_html(const std::string& id, const std::string& title, const std::string& how) {
  return fmt::format("<div><h3>{}</h3><p class=\"how\">{}</p><div class=\"plot\" id=\"{}\"></div></div>", title, how,
                     id);
}

std::string document_html(const std::string& title, const std::string& body, const std::vector<Plot>& plots) {
  auto data = nlohmann::json::array();
  for (const Plot& p : plots) data.push_back(to_json(p));
  std::string s =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\">";
  s += fmt::format("<title>{}</title><style>", escaped(title));
  s += embedded::uPlot_min_css;
  s += embedded::page_css;
  s += "</style></head><body>" + body;
  s += "<noscript><p>The curves need a script; every number stands in the tables.</p></noscript>";
  s += "<script type=\"application/json\" id=\"plots\">" +
       inside_script(data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) + "</script><script>";
  s += embedded::uPlot_iife_min_js;
  s += "</script><script>";
  s += embedded::plots_js;
  return s + "</script></body></html>\n";
}

}  // namespace stillpoint::report
