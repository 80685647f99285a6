#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds the documentation's site into a folder and checks its links: build_site.py FOLDER. Called by scripts/site.sh.

1. A copy of all pages (build/site-source), whose links lead to what the site has: a source file is a page with its text, a
   folder its README or a list. Lists get the empty line and the indentation that Python-Markdown wants.
2. Doxygen over the public headers, into api/. 3. mkdocs. 4. The search is made to work from the disk, without a server, and
   sources are left out of it. 5. Every link, picture and anchor of every page is looked up.
"""
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import urllib.parse

import check_docs
import public_headers

TOP = public_headers.TOP
SOURCE = os.path.join(TOP, "build", "site-source")
TEXT = {".h": "cpp", ".cpp": "cpp", ".py": "python", ".sh": "bash", ".cmake": "cmake", ".txt": "text", ".toml": "toml",
        ".sv": "systemverilog", ".v": "verilog", ".json": "json", ".yml": "yaml", ".cff": "yaml", ".js": "js", ".css": "css",
        ".mjs": "js", ".in": "text", ".supp": "text", "": "text"}
LARGEST = 200_000  # bytes of a source that becomes a page
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
SECTIONS = (("Guide", "docs/guide"), ("Model", "docs/model"), ("Results", "docs/results"), ("Notes", "docs/notes"))


def slug(text, separator):
    """Names of headings as a forge makes them; repeated ones are told apart by mkdocs."""
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", separator)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def outside_code(text, change):
    """change() of what lies between blocks of code."""
    parts = re.split(r"(^ *```.*?^ *```[^\n]*$)", text, flags=re.M | re.S)
    return "".join(part if number % 2 else change(part) for number, part in enumerate(parts))


def for_python_markdown(text):
    """Lists and tables begin after an empty line, and what belongs to an item is indented by four."""
    out, item, code = [], False, False
    for line in text.split("\n"):
        plain = line.lstrip(" ")
        indent = len(line) - len(plain)
        begins = re.match(r"(?:[*+-]|\d+\.) +\S", plain)
        before = out[-1].strip() if out else ""
        if plain.startswith("```"):
            code = not code
        elif not code and (begins or plain.startswith("|")) and before and not out[-1].lstrip().startswith("|"):
            if not (begins and item):  # the first of a list
                out.append("")
        if item and indent:
            line = " " * (4 * ((indent + 1) // 3 if indent < 6 else 2)) + plain if not code or plain.startswith("```") else "  " + line
        if not code and not plain.startswith("```"):
            if begins:
                item = True
            elif plain and not indent and not before:
                item = False
        out.append(line)
    return "\n".join(out)


class Copy:
    def __init__(self):
        self.tracked = set(check_docs.tracked(TOP))
        self.pages = sorted(f for f in self.tracked if f.endswith(".md") and not f.startswith("."))
        self.sources, self.raw, self.lists = set(), set(), set()

    def leads_to(self, page, link):
        """The link as it must be in the copy."""
        if re.match(r"[a-z]+:|#", link):
            return link
        target, mark, anchor = link.partition("#")
        place = os.path.normpath(os.path.join(os.path.dirname(page), target))
        if target.startswith("../../") and place.startswith(".."):
            return None  # of the forge: compare, releases
        full = os.path.join(TOP, place)
        if os.path.isdir(full):
            if f"{place}/README.md" not in self.tracked:
                self.lists.add(place)
            place += "/README.md"
        elif not place.endswith(".md"):
            if os.path.splitext(place)[1] in TEXT and os.path.getsize(full) < LARGEST:
                self.sources.add(place)
                place, mark = place + ".md", ""
            else:
                self.raw.add(place)
        elif place.startswith("."):
            return None
        return os.path.relpath(place, os.path.dirname(page) or ".") + (mark + anchor if mark else "")

    def changed(self, page, text):
        def link(found):
            target = self.leads_to(page, found.group(2))
            return found.group(1) + target + found.group(3) if target else f"]({found.group(2)})"

        text = outside_code(text, lambda part: LINK.sub(link, part))
        text = re.sub(r"^\[[^\]]+\]: \.\./.*\n+", "", text, flags=re.M)  # links of CHANGELOG.md to the forge
        return for_python_markdown(text)

    def make(self):
        shutil.rmtree(SOURCE, ignore_errors=True)
        for page in self.pages:
            text = read(os.path.join(TOP, page))
            self.raw |= {os.path.normpath(os.path.join(os.path.dirname(page), name))
                         for name in re.findall(r'<img src="([^":]+)"', text)}
            write(os.path.join(SOURCE, page), self.changed(page, text))
        for folder in sorted(self.lists):
            below = sorted({file[len(folder) + 1:].split("/")[0] for file in self.tracked if file.startswith(folder + "/")})
            text = f"# {folder}\n\n" + "".join(f"* [{name}]({name})\n" for name in below
                                              if os.path.isfile(os.path.join(TOP, folder, name)))
            write(os.path.join(SOURCE, folder, "README.md"), self.changed(folder + "/README.md", text))
        for file in sorted(self.sources):
            language = TEXT[os.path.splitext(file)[1]]
            text = read(os.path.join(TOP, file)).rstrip("\n")
            write(os.path.join(SOURCE, file + ".md"), f"# {file}\n\n~~~~~~ {language}\n{text}\n~~~~~~\n")
        for file in sorted(self.raw | {"docs/site/site.css"}):
            os.makedirs(os.path.dirname(os.path.join(SOURCE, file)), exist_ok=True)
            if file.endswith(".svg"):  # their boxes lead to pages
                text = re.sub(r'(<a href="[^":#]+)\.md', r"\1.html", read(os.path.join(TOP, file)))
                write(os.path.join(SOURCE, file), text)
            else:
                shutil.copyfile(os.path.join(TOP, file), os.path.join(SOURCE, file))

    def navigation(self):
        """Tabs: the sections of docs/ in the order in which docs/README.md names their pages."""
        order = re.findall(r"\]\(([\w/.-]+\.md)", read(os.path.join(TOP, "docs", "README.md")))
        rank = {os.path.normpath("docs/" + page): number for number, page in reversed(list(enumerate(order)))}

        def entries(pages):
            return [{title(read(os.path.join(TOP, page))): page} for page in pages]

        tops = ["docs/README.md", "docs/architecture.md", "docs/glossary.md", "docs/validation.md", "ARTIFACT.md"]
        tabs = [{"GRTX-TLM": ["README.md", *entries(tops)]}]
        for name, folder in SECTIONS:
            pages = [page for page in self.pages if page.startswith(folder + "/")]
            pages.sort(key=lambda page: (os.path.basename(page) != "README.md" or page.count("/") > 2, rank.get(page, 999), page))
            tabs.append({name: [pages[0], *entries(pages[1:])] if pages[0].endswith("README.md") else entries(pages)})
        build = ["docs/api.md", "docs/add-a-module.md", "CONTRIBUTING.md", "RELEASING.md", "CHANGELOG.md", "SECURITY.md",
                 "CODE_OF_CONDUCT.md", "scripts/README.md", "tests/README.md", "examples/README.md"]
        tabs.append({"Build on it": [{"Public headers": "api/index.html"}, *entries(p for p in build if p in self.tracked)]})
        return tabs


def title(text):
    return re.search(r"^# (.*)", text, re.M).group(1).replace("`", "")


def doxygen():
    config = read(os.path.join(TOP, "docs", "api", "Doxyfile"))
    version = re.search(r"^project\(grtx_tlm VERSION (\S+)", read(os.path.join(TOP, "CMakeLists.txt")), re.M).group(1)
    config += f"\nINPUT = {' '.join(public_headers.public())}\nPROJECT_NUMBER = {version}\n"
    config += f'OUTPUT_DIRECTORY = "{SOURCE}"\nHTML_OUTPUT = api\n'
    run = subprocess.run(["doxygen", "-"], input=config, capture_output=True, text=True, cwd=TOP, check=False)
    if run.returncode != 0:
        sys.exit("site: doxygen: " + run.stderr)
    return [line for line in run.stderr.splitlines() if "warning" in line or "error" in line]


def mkdocs(site, navigation):
    # JSON is YAML: what is written by the machine goes below what is written by hand.
    config = read(os.path.join(TOP, "mkdocs.yml"))
    config = re.sub(r"^(docs_dir|site_dir): .*\n", "", config, flags=re.M)
    config += f"\ndocs_dir: {json.dumps(SOURCE)}\nsite_dir: {json.dumps(site)}\nnav: {json.dumps(navigation)}\n"
    path = os.path.join(TOP, "build", "site.yml")
    write(path, config)
    environment = dict(os.environ, PYTHONPATH=os.path.join(TOP, "scripts"), PYTHONDONTWRITEBYTECODE="1")
    run = subprocess.run([shutil.which("mkdocs"), "build", "--quiet", "-f", path], env=environment, capture_output=True,
                         text=True, check=False)
    sys.stderr.write("".join(line + "\n" for line in run.stderr.splitlines() if not line.startswith("INFO")))
    if run.returncode != 0:
        sys.exit("site: mkdocs ends with code " + str(run.returncode))


def search_from_disk(site, sources):
    """Browsers let no page fetch from the disk: there the index and the worker's program come as a script."""
    path = os.path.join(site, "search", "search_index.json")
    index = json.loads(read(path))
    left_out = {file + ".html" for file in sources}
    index["docs"] = [entry for entry in index["docs"] if entry["location"].partition("#")[0] not in left_out]
    write(path, json.dumps(index, ensure_ascii=False, separators=(",", ":")))
    scripts = os.path.join(site, "assets", "javascripts", "workers")
    worker = next(name for name in os.listdir(scripts) if name.startswith("search.") and name.endswith(".js"))
    text = json.dumps(read(os.path.join(scripts, worker))).replace("</", "<\\/")
    data = json.dumps(index, ensure_ascii=False).replace("</", "<\\/")
    write(os.path.join(site, "search", "from_disk.js"),
          f"var __search={{index:Promise.resolve({data}),"
          f'worker:URL.createObjectURL(new Blob([{text}],{{type:"text/javascript"}}))}};\n')
    for page in html_pages(site):
        text = read(page)
        bundle = re.search(r'<script src="[^"]*assets/javascripts/bundle\.', text)
        if bundle:
            up = os.path.relpath(os.path.join(site, "search", "from_disk.js"), os.path.dirname(page))
            loader = f"<script>if(location.protocol===\"file:\")document.write('<script src=\"{up}\"><\\/script>')</script>"
            write(page, text[:bundle.start()] + loader + text[bundle.start():])


def html_pages(site):
    return sorted(os.path.join(folder, name) for folder, _, names in os.walk(site) for name in names if name.endswith(".html"))


class Links(html.parser.HTMLParser):
    """Links and anchors of a page."""

    def __init__(self):
        super().__init__()
        self.links, self.anchors = set(), set()

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.add(value)
            elif name == "id" or (name == "name" and tag == "a"):
                self.anchors.add(value)


def broken(site):
    known = {}

    def page(path):
        if path not in known:
            known[path] = Links()
            known[path].feed(read(path))
        return known[path]

    found, links = [], 0
    for path in html_pages(site):
        name = os.path.relpath(path, site)
        if name == "404.html":
            continue  # its links begin at the site's address
        for link in sorted(page(path).links):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc or link.startswith("javascript"):
                continue
            links += 1
            target = os.path.normpath(os.path.join(os.path.dirname(path), urllib.parse.unquote(parts.path))) if parts.path else path
            if os.path.isdir(target):
                target = os.path.join(target, "index.html")
            if not os.path.exists(target):
                found.append(f"{name}: {link} does not exist")
            elif parts.fragment and target.endswith(".html") and not name.startswith("api/"):
                fragment = urllib.parse.unquote(parts.fragment)
                if fragment not in page(target).anchors and not fragment.startswith("__"):
                    found.append(f"{name}: {link}: no such anchor")
    return found, links


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip())
    site = os.path.abspath(sys.argv[1])
    copy = Copy()
    copy.make()
    for line in doxygen():
        print("doxygen: " + line, file=sys.stderr)
    mkdocs(site, copy.navigation())
    search_from_disk(site, copy.sources)
    found, links = broken(site)
    for line in found:
        print(line)
    pages = len(html_pages(site))
    print(f"site: {pages} pages, {links} links, {len(found)} of them broken: {site}/index.html", file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
