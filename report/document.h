/// A page as one HTML file that needs no network and reads without a script: words and tables are in it, and curves are
/// drawn by uPlot, which is part of it.
#pragma once
#include <string>
#include <vector>

#include "report/plot.h"

namespace stillpoint::report {

/// Text made safe for HTML.
[[nodiscard]] std::string escaped(const std::string& text);

/// A heading, how to read the figure, and the place where the plot of that identifier is drawn; all HTML.
[[nodiscard]] std::string figure_html(const std::string& id, const std::string& title, const std::string& how);

/// `title` is text, `body` HTML with a place for each plot.
[[nodiscard]] std::string document_html(const std::string& title, const std::string& body,
                                        const std::vector<Plot>& plots);

}  // namespace stillpoint::report
