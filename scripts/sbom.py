#!/usr/bin/env python3
"""Software bill of materials of a build, SPDX 2.3 in JSON: sbom.py BUILD_FOLDER [PROGRAM...] > sbom.spdx.json

Without PROGRAM: everything that is installed (BUILD_FOLDER/package/programs.txt). For each program the shared libraries
that the loader finds for it, the Debian packages whose headers or static libraries are compiled in, and what it contains
of third_party/. Exit code: 66 when a program is not built or a library is not there."""
import argparse
import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys

import debian_package

UNKNOWN = "NOASSERTION"


def told(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def digest(path, algorithm="sha256"):
    return hashlib.new(algorithm, pathlib.Path(path).read_bytes()).hexdigest()


def loaded(program):
    """{name: path} of the shared libraries that the loader finds for a program; the kernel's own has no file."""
    out = {}
    for line in told("ldd", str(program)).splitlines():
        found = re.fullmatch(r"\s*(\S+)(?: => (.*?))?(?: \(0x[0-9a-f]+\))?", line)
        name, path = found[1], found[2] or found[1]
        if path == "not found":
            raise FileNotFoundError(f"{program}: {name} is not found")
        if path.startswith("/"):
            out[pathlib.Path(name).name] = path
    return out


def needed(path):
    return re.findall(r"\(NEEDED\).*\[(.+)\]", told("readelf", "-dW", str(path)))


def compiled_in(root, build, program):
    """What of outside the project the program is made of: headers and static libraries of the system, files of third_party/."""
    inputs = told("ninja", "-C", str(build), "-t", "inputs", str(program.relative_to(build))).splitlines()
    objects = [line for line in inputs if line.endswith(".o")]
    files = [pathlib.Path(build, line) for line in inputs]
    for line in told("ninja", "-C", str(build), "-t", "deps", *objects).splitlines():
        if line.startswith("    "):
            files.append(pathlib.Path(build, line.strip()))
    real = {os.path.normpath(f) for f in files}
    headers = {f for f in real if f.startswith("/usr/") and not re.search(r"\.(so[.\d]*|a|o)$", f)}
    archives = {f for f in real if f.startswith("/usr/") and f.endswith(".a")}
    parts = {pathlib.Path(f).relative_to(root / "third_party").parts[0] for f in real if f.startswith(f"{root}/third_party/")}
    return headers, archives, sorted(parts)


class Bill:
    def __init__(self, build):
        self.build = build
        cache = (build / "CMakeCache.txt").read_text()
        self.version = re.search(r"CMAKE_PROJECT_VERSION:\w+=(.+)", cache)[1]
        self.root = pathlib.Path(re.search(r"CMAKE_HOME_DIRECTORY:\w+=(.+)", cache)[1])
        self.packages, self.files, self.relationships, self.texts = {}, {}, [], {}
        self.debian = {}

    def relate(self, one, kind, other, comment=""):
        relation = {"spdxElementId": one, "relationshipType": kind, "relatedSpdxElement": other}
        if comment:
            relation["comment"] = comment
        if relation not in self.relationships:
            self.relationships.append(relation)

    def add(self, name, **fields):
        key = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", name.replace("+", "plus"))
        if self.packages.setdefault(key, {"name": name})["name"] != name:
            raise ValueError(f"{name} and {self.packages[key]['name']} would share {key}")
        self.packages[key].update(SPDXID=key, downloadLocation=UNKNOWN, filesAnalyzed=False, **fields)
        return key

    def ours(self, path):
        copyright = re.search(r"Copyright.*", (self.root / "LICENSE").read_text())[0]
        return self.add(path.name, versionInfo=self.version, packageFileName=path.name, licenseConcluded="MIT",
                        licenseDeclared="MIT", copyrightText=copyright, supplier="Organization: Stillpoint maintainers",
                        primaryPackagePurpose="LIBRARY" if ".so" in path.name else "APPLICATION",
                        checksums=[{"algorithm": "SHA256", "checksumValue": digest(path)}])

    def of_debian(self, name, package, **fields):
        """An element that comes in a Debian package: the package itself, or one shared library of it."""
        if package not in self.debian:
            self.debian[package] = debian_package.installed(package)
        p = self.debian[package]
        self.texts.update(p.texts)
        if p.comment:
            fields["licenseComments"] = p.comment
        purl = f"pkg:deb/debian/{p.name}@{p.version}?arch={p.architecture}&distro=bookworm&upstream={p.source}"
        return self.add(name, versionInfo=p.version, supplier="Organization: Debian", licenseDeclared=p.licence,
                        copyrightText=p.copyright or UNKNOWN, primaryPackagePurpose="LIBRARY",
                        sourceInfo=f"Debian package {p.name} {p.version}, from the source package {p.source}",
                        externalRefs=[{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                       "referenceLocator": purl.replace("+", "%2B")}], **fields)

    def third_party(self, folder):
        """The first line of the folder's README says what it is: NAME VERSION (LICENCE, HOLDER), from the npm package `NAME`"""
        says = re.match(r"(\S+) (\S+) \((\S+), (.+?)\), from the npm package `(\S+?)`",
                        (self.root / "third_party" / folder / "README.md").read_text())
        name, version, licence, holder, npm = says.groups()
        sums = []
        key = self.add(f"third_party/{folder}", versionInfo=version, supplier=f"Person: {holder}", licenseConcluded=licence,
                       licenseDeclared=licence, copyrightText=holder, primaryPackagePurpose="LIBRARY",
                       sourceInfo=f"{name}, unchanged, in third_party/{folder}",
                       externalRefs=[{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                                      "referenceLocator": f"pkg:npm/{npm}@{version}"}])
        for path in sorted((self.root / "third_party" / folder).iterdir()):
            relative = f"./{path.relative_to(self.root)}"
            file = key + "-" + re.sub(r"[^A-Za-z0-9.]+", "-", path.name)
            sums.append(digest(path, "sha1"))
            self.files[file] = {"SPDXID": file, "fileName": relative, "licenseConcluded": licence,
                                "licenseInfoInFiles": [licence], "copyrightText": holder,
                                "checksums": [{"algorithm": "SHA1", "checksumValue": sums[-1]},
                                              {"algorithm": "SHA256", "checksumValue": digest(path)}]}
            self.relate(key, "CONTAINS", file)
        code = hashlib.sha1("".join(sorted(sums)).encode()).hexdigest()
        self.packages[key].update(filesAnalyzed=True, packageVerificationCode={"packageVerificationCodeValue": code},
                                  licenseInfoFromFiles=[licence])
        return key

    def libraries(self, program, key):
        paths = loaded(program)
        owner = debian_package.owners([p for p in paths.values() if not p.startswith(f"{self.build}/")])
        keys = {}
        for name, path in paths.items():
            if path.startswith(f"{self.build}/"):
                keys[name] = self.ours(pathlib.Path(path).resolve())
            elif path in owner:
                keys[name] = self.of_debian(name, owner[path], packageFileName=path,
                                            checksums=[{"algorithm": "SHA256", "checksumValue": digest(path)}])
            else:
                raise FileNotFoundError(f"{path}, which {program.name} links, is of no Debian package")
        for one, at in [(key, program), *((keys[n], p) for n, p in paths.items())]:
            for name in needed(at):
                self.relate(one, "DEPENDS_ON", keys[name])

    def program(self, path):
        key = self.ours(path)
        self.relate("SPDXRef-DOCUMENT", "DESCRIBES", key)
        self.libraries(path, key)
        headers, archives, parts = compiled_in(self.root, self.build, path)
        for files, how in ((headers, "headers: their inline and template code is part of the program"),
                           (archives, "static library")):
            for package in sorted(set(debian_package.owners(files).values())):
                self.relate(key, "STATIC_LINK", self.of_debian(package, package), how)
        for folder in parts:
            self.relate(key, "CONTAINS", self.third_party(folder))

    def document(self):
        at = int(os.environ.get("SOURCE_DATE_EPOCH", datetime.datetime.now().timestamp()))
        body = {"packages": [self.packages[k] for k in sorted(self.packages)],
                "files": [self.files[k] for k in sorted(self.files)],
                "relationships": self.relationships,
                "hasExtractedLicensingInfos": [{"licenseId": k, "name": k.removeprefix("LicenseRef-"), "extractedText": v}
                                               for k, v in sorted(self.texts.items())]}
        content = hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()
        return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
                "name": f"stillpoint-{self.version}",
                "documentNamespace": f"https://stillpoint.invalid/spdx/stillpoint-{self.version}-{content}",
                "creationInfo": {"created": datetime.datetime.fromtimestamp(at, datetime.UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
                                 "creators": ["Organization: Stillpoint maintainers", "Tool: scripts/sbom.py"]},
                "comment": "Libraries that a program opens by itself while it runs (dlopen) are not listed.", **body}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", type=lambda p: pathlib.Path(p).resolve())
    arguments.add_argument("programs", nargs="*", type=lambda p: pathlib.Path(p).resolve())
    given = arguments.parse_args()
    programs = given.programs or [pathlib.Path(p) for p in (given.build / "package/programs.txt").read_text().split()]
    absent = [str(p) for p in programs if not p.exists()]
    if absent:
        print(f"not built: {' '.join(absent)}", file=sys.stderr)
        return 66
    bill = Bill(given.build)
    try:
        for program in programs:
            bill.program(program)
    except FileNotFoundError as fault:
        print(fault, file=sys.stderr)
        return 66
    json.dump(bill.document(), sys.stdout, indent=1, ensure_ascii=False)
    print()
    return 0


if __name__ == "__main__":
    sys.exit(main())
