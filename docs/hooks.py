"""What the site needs beyond mkdocs: the repository's other files that the pages link to, and the commands' own help.

A page in docs/ may link to anything in the repository. What lies outside docs/ comes into the site under its own path
in the repository (`../diagrams/README.md` as `diagrams/README.md`), and links are turned accordingly. A link to nothing
stays as it is, so that a strict build refuses it.
"""

import posixpath
import re
from pathlib import Path

import typer.main
from markdown.extensions.toc import slugify
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
LINK = re.compile(r"(!?\[[^\]]*\]\()([^)\s#]+)([^)\s]*\))")
ALWAYS = ("CHANGELOG.md", "diagrams/README.md")
HELP_PAGE = "commands.md"


def on_config(config):
    """Give every heading an anchor that begins with a letter: the theme looks for them as CSS selectors."""
    config.mdx_configs["toc"]["slugify"] = _anchor
    return config


def _anchor(heading: str, separator: str) -> str:
    """Return a heading's anchor."""
    found = slugify(heading, separator)
    return found if not found[:1].isdigit() else f"step{separator}{found}"


def on_post_page(output: str, **_) -> str:
    """Add what the theme's switch of day and night looks for where no code is coloured; without it, it gives up."""
    return output.replace(
        "</head>", '<style id="hljs-light"></style><style id="hljs-dark"></style></head>', 1
    )


def on_post_template(output: str, **_) -> str:
    """Do the same for the page that is shown where an address leads to nothing."""
    return on_post_page(output)


def on_files(files: Files, config) -> Files:
    """Add what pages link to outside docs/, what those pages link to, and the page of commands."""
    waiting = [ROOT / name for name in ALWAYS]
    waiting += [target for file in files if file.src_uri.endswith(".md") for target in _targets(_path(file))]
    while waiting:
        path = waiting.pop()
        name = _site_name(path)
        if path.is_relative_to(ROOT / "docs") or files.get_file_from_path(name) is not None:
            continue
        files.append(_file(name, config, abs_src_path=str(path)))
        waiting += _targets(path) if path.suffix == ".md" else ()
    files.append(_file(HELP_PAGE, config, content=_all_help()))
    return files


def on_page_markdown(markdown: str, page, **_) -> str:
    """Turn links between files of the repository into links between files of the site."""
    if page.file.src_uri == HELP_PAGE:
        return markdown
    here = _path(page.file).parent

    def turned(found: re.Match[str]) -> str:
        target = _resolved(here, found[2])
        if target is None:
            return found[0]
        folder = posixpath.dirname(page.file.src_uri) or "."
        return found[1] + posixpath.relpath(_site_name(target), folder) + found[3]

    return LINK.sub(turned, markdown)


def _file(name: str, config, **source) -> File:
    """Return a file of the site that does not lie in docs/."""
    file = File.generated(config, name, **source)
    file.use_directory_urls = config.use_directory_urls
    return file


def _targets(page: Path) -> list[Path]:
    """Return the files of the repository that a page links to."""
    links = LINK.finditer(page.read_text(encoding="utf-8"))
    return [target for found in links if (target := _resolved(page.parent, found[2])) is not None]


def _resolved(folder: Path, link: str) -> Path | None:
    """Return the file of the repository that a link means; a folder means its README; None elsewhere."""
    if "://" in link or link.startswith(("mailto:", "/")):
        return None
    target = (folder / link).resolve()
    target = target / "README.md" if target.is_dir() else target
    return target if target.is_file() and target.is_relative_to(ROOT) else None


def _path(file: File) -> Path:
    """Return where a page's text lies in the repository."""
    inside = ROOT / "docs" / file.src_uri
    return inside if inside.is_file() else ROOT / file.src_uri


def _site_name(path: Path) -> str:
    """Return the name of a file of the repository in the site."""
    inside = path.relative_to(ROOT)
    return inside.relative_to("docs").as_posix() if inside.parts[0] == "docs" else inside.as_posix()


def _all_help() -> str:
    """Return a page with what every command prints at `--help`."""
    from fsm_calib.cli import app

    parts = ["# Command line", "", "What `fsm-calib -h` prints, and `-h` behind each command."]
    return "\n".join([*parts, *_help_of(typer.main.get_command(app), "fsm-calib")]) + "\n"


def _help_of(command, name: str, above=None) -> list[str]:
    """Return the help of a command and of those below it, as lines of Markdown."""
    context = command.make_context(name, [], above, resilient_parsing=True, terminal_width=90)
    told = [f"    {line}".rstrip() for line in command.get_help(context).splitlines()]
    lines = ["", f"## {context.command_path}", "", *told]
    for below in getattr(command, "commands", {}).values():
        if not below.hidden:
            lines += _help_of(below, below.name, context)
    return lines
