# SPDX-License-Identifier: Apache-2.0
"""Hook of mkdocs (mkdocs.yml): what leaves docs/ leads to the forge that GRTX_FORGE names, as https://HOST/OWNER/NAME/blob/main/, and is
plain text without one."""
import glob
import os
import re

FORGE = os.environ.get("GRTX_FORGE", "")
LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\]]*\]|!\[[^\]]*\]\([^)]*\))*)\]\((\.\.[^)\s]*)\)")


def on_page_markdown(markdown, page, **_):
    def link(found):
        place = os.path.normpath(os.path.join("docs", os.path.dirname(page.file.src_path), found.group(2)))
        if place.split(os.sep)[0] == "docs":
            return found.group(0)
        return f"[{found.group(1)}]({FORGE}{place})" if FORGE else found.group(1)

    markdown = re.sub(r"^ {2,3}(?=(?:[*+-]|\d+\.) )", "    ", LINK.sub(link, markdown), flags=re.M)  # Python-Markdown indents by four
    return markdown + '\n\n<a href="api/index.html">The reference of the public headers</a>\n' if page.file.src_path == "api.md" else markdown


def on_post_build(config, **_):
    for name in glob.glob(os.path.join(config["site_dir"], "images", "*.svg")) if FORGE else ():  # their boxes are links
        with open(name, encoding="utf-8") as file:
            text = file.read()
        with open(name, "w", encoding="utf-8") as file:
            file.write(text.replace('<a href="../../', f'<a href="{FORGE}'))
