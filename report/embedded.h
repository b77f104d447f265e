/// The plotting library and the style of our pages, made part of the program at build time; the names are the files'.
#pragma once

namespace stillpoint::report::embedded {

extern const char uPlot_iife_min_js[], uPlot_min_css[], page_css[], plots_js[];

}  // namespace stillpoint::report::embedded
