#include "apps/stillpoint/page_document.h"

#include <cstddef>
#include <cstdint>

#include "diagnosis/prove/sha256.h"
#include "report/embedded.h"

namespace stillpoint::app {

namespace embedded {  // made at build time from the files of these names in apps/stillpoint/page/
extern const char live_css[], live_html[], live_js[], words_js[], body_js[], curves_js[], sphere_js[], panels_js[];
}

namespace {

/// Base64 of a digest written in hexadecimal, as Content-Security-Policy wants it.
std::string base64_of_hex(const std::string& hex) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t at = 0; at < hex.size(); at += 6) {  // three bytes become four digits
    const std::string part = hex.substr(at, 6);
    const auto bits = static_cast<std::uint32_t>(std::stoul(part, nullptr, 16)) << (24 - 4 * part.size());
    const std::size_t digits = part.size() / 2 + 1;
    for (std::size_t k = 0; k < 4; ++k) out += k < digits ? kDigits[(bits >> (18 - 6 * k)) & 63U] : '=';
  }
  return out;
}

std::string hash_source(const std::string& text) { return "'sha256-" + base64_of_hex(diag::sha256(text)) + "'"; }

}  // namespace

PageDocument page_document() {
  const std::string style =
      std::string(report::embedded::uPlot_min_css) + report::embedded::page_css + embedded::live_css;
  std::string script = std::string(report::embedded::uPlot_iife_min_js) + "\n";
  for (const char* part : {embedded::words_js, embedded::body_js, embedded::curves_js, embedded::sphere_js,
                           embedded::panels_js, embedded::live_js})
    script += part;
  PageDocument page;
  page.html =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>Stillpoint, live</title><link rel=\"icon\" href=\"data:,\"><style>" +
      style + "</style></head>" + embedded::live_html + "<script>" + script + "</script></html>\n";
  page.policy = "default-src 'none'; script-src " + hash_source(script) + "; style-src " + hash_source(style) +
                "; connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
  return page;
}

}  // namespace stillpoint::app
