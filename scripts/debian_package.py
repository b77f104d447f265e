"""What Debian states of an installed package: version, source package, licence, copyright. For sbom.py.

The licence is read from /usr/share/doc/PACKAGE/copyright where that file is machine-readable (DEP-5); elsewhere from the
table FREE_FORM, or the whole file stands as a licence of its own."""
import dataclasses
import pathlib
import re
import subprocess

# Debian's short names are mostly those of SPDX, in any case; these are not.
SPDX_OF = {name.lower(): spdx for name, spdx in {
    "AFL-2.1": "AFL-2.1", "Apache-2": "Apache-2.0", "Apache-2.0": "Apache-2.0", "Artistic": "Artistic-1.0-Perl",
    "Boost": "BSL-1.0", "BSD-2-clause": "BSD-2-Clause", "BSD-3-clause": "BSD-3-Clause", "CC0-1.0": "CC0-1.0",
    "Expat": "MIT", "MIT": "MIT", "FSFAP": "FSFAP", "ISC": "ISC", "MPL-2": "MPL-2.0", "MPL-2.0": "MPL-2.0",
    "Unlicense": "Unlicense", "X11": "X11", "Zlib": "Zlib", "zlib/libpng": "Zlib",
    "GPL-1+": "GPL-1.0-or-later", "GPL-2": "GPL-2.0-only", "GPL-2+": "GPL-2.0-or-later",
    "GPL-2.0+": "GPL-2.0-or-later", "GPL-3": "GPL-3.0-only", "GPL-3+": "GPL-3.0-or-later",
    "LGPL-2.1": "LGPL-2.1-only", "LGPL-2.1+": "LGPL-2.1-or-later", "LGPL-3+": "LGPL-3.0-or-later",
    "GPL-2 with Linux-syscall-note exception": "GPL-2.0-only WITH Linux-syscall-note",
}.items()}

# Source packages whose copyright file is prose: the libraries' licence as it says there.
FREE_FORM = {
    "avahi": "LGPL-2.0-or-later",
    "gcc-12": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "glibc": "LGPL-2.1-or-later",
    "libgcrypt20": "LGPL-2.1-or-later",
    "libusb-1.0": "LGPL-2.1-or-later",
}


@dataclasses.dataclass
class Package:
    name: str
    version: str
    source: str
    architecture: str
    licence: str = ""
    comment: str = ""                                   # what the other files of the source package are under
    copyright: str = ""
    texts: dict = dataclasses.field(default_factory=dict)  # {LicenseRef-...: text} of what SPDX has no name for


def owners(paths):
    """{path: Debian package}; a path that no package owns is absent. /lib and /usr/lib are one folder, dpkg knows one name."""
    names = {}
    for path in paths:
        real = str(pathlib.Path(path).resolve())
        names[path] = {n for p in (path, real) for n in (p, p.removeprefix("/usr"), "/usr" + p)}
    asked = sorted(set().union(*names.values())) if names else []
    owner = {}
    for at in range(0, len(asked), 1000):
        told = subprocess.run(["dpkg", "-S", *asked[at:at + 1000]], capture_output=True, text=True).stdout
        for line in told.splitlines():
            found = re.fullmatch(r"([^\s:,]+)(?::\w+)?(?:, .*)?: (/.*)", line)
            if found:
                owner[found[2]] = found[1]
    return {path: owner[n] for path, candidates in names.items() for n in sorted(candidates) if n in owner}


def paragraphs(text):
    """The paragraphs of a Debian control file: [{field: value}], field names in lower case."""
    out = []
    for block in re.split(r"\n[ \t]*\n", text):
        fields, key = {}, None
        for line in block.splitlines():
            start = re.match(r"([A-Za-z][A-Za-z-]*):(.*)", line)
            if start:
                key = start[1].lower()
                fields[key] = start[2].strip()
            elif key and line[:1] in " \t":
                fields[key] += "\n" + line.strip()
        if fields:
            out.append(fields)
    return out


def expression(short, package, texts):
    """The SPDX expression of a DEP-5 licence name such as "GPL-2+ or BSD-3-clause, and Expat"."""
    groups = []
    for group in re.split(r",\s*and\s+", short.strip()):  # a comma binds weakest
        ands = []
        for part in re.split(r"\s+and\s+", group):
            ors = [one(name, package, texts) for name in re.split(r"\s+or\s+|\s+and/or\s+", part)]
            ands.append(" OR ".join(ors) if len(ors) == 1 else "(" + " OR ".join(ors) + ")")
        groups.append(" AND ".join(ands))
    return " AND ".join(groups)


def one(name, package, texts):
    if name.lower() in SPDX_OF:
        return SPDX_OF[name.lower()]
    reference = f"LicenseRef-{package.source}-{re.sub(r'[^A-Za-z0-9.]+', '-', name).strip('-')}"
    package.texts[reference] = texts.get(name.lower()) or f"{name}: see /usr/share/doc/{package.name}/copyright"
    return reference


def read_copyright(package, text):
    parts = paragraphs(text)
    licensed = [p for p in parts if "license" in p and "files" in p and p["files"].split() != ["debian/*"]]
    if not licensed or "copyright-format" not in parts[0].get("format", ""):
        read_prose(package, text)
        return
    texts = {}
    for p in parts:
        name, _, body = p.get("license", "").partition("\n")
        if name and body:
            texts.setdefault(name.strip().lower(), body)
    short = [p["license"].split("\n")[0].strip() for p in licensed]
    main = [name for p, name in zip(licensed, short) if "*" in p["files"].split() and name]
    named = main[:1] or sorted({name for name in short if name})
    package.licence = " AND ".join(dict.fromkeys(expression(name, package, texts) for name in named))
    others = sorted({name for name in short if name} - set(named))
    if others:
        package.comment = "Other files of the source package: " + "; ".join(others) + "."
    holders = [line for p in licensed for line in p.get("copyright", "").split("\n") if line]
    package.copyright = "\n".join(dict.fromkeys(holders))


def read_prose(package, text):
    lines = [line.strip(" *\t") for line in text.splitlines() if re.search(r"copyright \(c\)", line, re.IGNORECASE)]
    package.copyright = "\n".join(dict.fromkeys(lines))
    if package.source in FREE_FORM:
        package.licence = FREE_FORM[package.source]
        package.comment = f"/usr/share/doc/{package.name}/copyright names more for other files of the source package."
    else:
        package.licence = f"LicenseRef-{package.source}-copyright"
        package.texts[package.licence] = text


def installed(name):
    """What dpkg and the copyright file say of an installed package."""
    shown = subprocess.run(["dpkg-query", "-W", "-f", "${Version}\t${source:Package}\t${Architecture}\n", name],
                           check=True, capture_output=True, text=True).stdout
    package = Package(name, *shown.splitlines()[0].split("\t"))
    path = pathlib.Path(f"/usr/share/doc/{name}/copyright")
    if not path.exists():  # a slim image leaves documentation out, but for this
        raise FileNotFoundError(f"{path}: without it the licence of {name} is not known")
    read_copyright(package, path.read_text(errors="replace"))
    return package
