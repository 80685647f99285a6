// SPDX-License-Identifier: Apache-2.0
#include "grtx/report/page/page.h"

#include <fmt/format.h>

#include "grtx/report/page/assets.h"
#include "grtx/report/page/html.h"

namespace grtx::report {
namespace {

std::string navigation(const std::string& body) {
  // In every section with an id, a heading follows directly.
  std::string links;
  const std::string begin = "<section id=\"";
  for (std::size_t at = body.find(begin); at != std::string::npos; at = body.find(begin, at + 1)) {
    const std::size_t id = at + begin.size();
    const std::size_t heading = body.find("<h2>", id) + 4;
    links += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", body.substr(id, body.find('"', id) - id),
                         body.substr(heading, body.find("</h2>", heading) - heading));
  }
  return "<nav aria-label=\"Contents\"><ul>\n" + links + "</ul></nav>\n";
}

}  // namespace

std::string page_head(const std::string& title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'; script-src 'unsafe-inline' 'unsafe-eval'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"grtx {}\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{}</title>\n<style>\n",
      GRTX_VERSION, escape(title));
}

std::string html_page(const std::string& title, const std::string& command, const std::string& body) {
  std::string page = page_head(title);
  page += page_style();
  page += "</style>\n</head>\n<body>\n<a class=\"skip\" href=\"#content\">To the content</a>\n<header><h1>" +
          escape(title) + "</h1>\n" + navigation(body) + "</header>\n<main id=\"content\">\n" + body +
          "</main>\n<footer><p>Written by grtx " GRTX_VERSION " " + command +
          ". This file holds everything it shows and loads nothing.</p></footer>\n";
  if (!chart_library().empty()) {
    page += "<script>\n";
    page += chart_library();
    page += "</script>\n<script>\n";
    page += export_script();
    page += "</script>\n";
  }
  if (body.find("<div class=\"explorer\"") != std::string::npos) {
    page += "<script>\n";
    page += explore_charts_script();
    page += explore_script();
    page += "</script>\n";
  }
  page += "<script>\n";
  page += page_script();
  return page + "</script>\n</body>\n</html>\n";
}

}  // namespace grtx::report
