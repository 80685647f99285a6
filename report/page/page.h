// SPDX-License-Identifier: Apache-2.0
// The frame that all HTML pages of the program share.
#pragma once

#include <string>

namespace grtx::report {

/// Start of a page up to its styles: document type, title, and a content security policy that forbids loading anything
/// ('unsafe-eval', since Vega compiles expressions). title: plain text.
std::string page_head(const std::string& title);

/// A complete page. title: plain text; command: the command that writes it; body: sections, each with an id followed
/// directly by a heading; the table of contents links to them.
std::string html_page(const std::string& title, const std::string& command, const std::string& body);

}  // namespace grtx::report
