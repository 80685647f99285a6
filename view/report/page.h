// What every page of the program has around its content.
#pragma once

#include <string>

namespace grtx::sim {

/// What stands before a page's first style: document type, title, and a policy by which the browser loads nothing,
/// whatever the content says (the charts' expressions are compiled, hence 'unsafe-eval'). title: plain text.
std::string page_head(const std::string& title);

/// A whole page. title: plain text; command: that writes it; body: sections, each with an id and a heading right behind
/// it, to which the page's list of contents leads.
std::string html_page(const std::string& title, const std::string& command, const std::string& body);

}  // namespace grtx::sim
