#!/usr/bin/env python3
"""The bill of materials of the programs of a build is whole and well-formed: sbom_test.py SOURCE BUILD [PROGRAM...]"""
import datetime
import json
import pathlib
import re
import subprocess
import sys
import unittest

SOURCE, BUILD, *PROGRAMS = map(pathlib.Path, sys.argv[1:])
LICENCE = re.compile(r"[A-Za-z0-9.+-]+( WITH [A-Za-z0-9.-]+)?")
KINDS = {"DESCRIBES", "DEPENDS_ON", "STATIC_LINK", "CONTAINS"}


def identifiers(expression):
    return [part.strip("() ") for part in re.split(r" AND | OR ", expression)]


class Sbom(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        programs = PROGRAMS or [pathlib.Path(p) for p in (BUILD / "package/programs.txt").read_text().split()]
        done = subprocess.run([sys.executable, SOURCE / "scripts/sbom.py", BUILD, *programs], capture_output=True, text=True)
        if done.returncode != 0:
            raise AssertionError(done.stderr)
        cls.bill = json.loads(done.stdout)
        cls.packages = {p["SPDXID"]: p for p in cls.bill["packages"]}
        cls.by_name = {p["name"]: p for p in cls.bill["packages"]}
        cls.programs = [p.resolve() for p in programs]

    def related(self, one, kind):
        return {r["relatedSpdxElement"] for r in self.bill["relationships"]
                if r["spdxElementId"] == one and r["relationshipType"] == kind}

    def test_every_library_that_the_loader_names_is_reached_from_its_program(self):
        for program in self.programs:
            told = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
            named = {pathlib.Path(n).resolve() for n in re.findall(r"(/\S+) \(0x", told)}
            self.assertGreater(len(named), 2, program)  # the C and the C++ library at least
            reached, open_ = set(), {self.by_name[program.name]["SPDXID"]}
            while open_:
                one = open_.pop()
                reached.add(one)
                open_ |= self.related(one, "DEPENDS_ON") - reached
            files = {(BUILD / self.packages[k]["packageFileName"]).resolve() for k in reached}
            self.assertEqual(named - files, set(), f"{program.name}: linked and not in the bill")

    def test_every_package_states_its_version_its_licence_and_its_origin(self):
        for p in self.bill["packages"]:
            for field in ("name", "versionInfo", "downloadLocation", "licenseDeclared", "copyrightText", "supplier"):
                self.assertTrue(p.get(field), f"{p['name']}: {field}")
            self.assertNotIn(p["licenseDeclared"], ("NOASSERTION", "NONE"), p["name"])
            if p["supplier"] == "Organization: Debian":
                package, version = re.match(r"Debian package (\S+) (\S+),", p["sourceInfo"]).groups()
                known = subprocess.run(["dpkg-query", "-W", "-f", "${Version}\n", package], check=True, capture_output=True, text=True)
                self.assertIn(version, known.stdout.split(), p["name"])
                self.assertEqual(version, p["versionInfo"])

    def test_every_licence_is_of_the_list_of_spdx_or_quoted(self):
        quoted = {t["licenseId"]: t["extractedText"] for t in self.bill["hasExtractedLicensingInfos"]}
        sys.path.insert(0, str(SOURCE / "scripts"))
        import debian_package
        listed = set(debian_package.SPDX_OF.values()) | set(debian_package.FREE_FORM.values())
        for p in self.bill["packages"]:
            for name in identifiers(p["licenseDeclared"]):
                self.assertRegex(name, LICENCE)
                self.assertTrue(name in listed or quoted.get(name), f"{p['name']}: {name}")

    def test_checksums_are_those_of_the_files(self):
        summed = [p for p in self.bill["packages"] if "checksums" in p]
        self.assertGreater(len(summed), len(self.programs))
        for p in summed:
            path = next((q for q in self.programs if q.name == p["packageFileName"]), p["packageFileName"])
            told = subprocess.run(["sha256sum", path], check=True, capture_output=True, text=True).stdout
            self.assertEqual(p["checksums"], [{"algorithm": "SHA256", "checksumValue": told.split()[0]}], p["name"])

    def test_header_only_libraries_and_third_party_files_are_named_where_they_are_compiled_in(self):
        linked = {p.name: {self.packages[k]["name"] for k in self.related(self.by_name[p.name]["SPDXID"], "STATIC_LINK")}
                  for p in self.programs}
        contained = {p.name: {self.packages[k]["name"] for k in self.related(self.by_name[p.name]["SPDXID"], "CONTAINS")}
                     for p in self.programs}
        wanted = {"stillpointd": {"libeigen3-dev", "libcli11-dev", "libexpected-dev", "libfmt-dev", "libfastrtps-dev"},
                  "stillpoint": {"libeigen3-dev", "libcli11-dev", "libcpp-httplib-dev", "nlohmann-json3-dev", "libexpected-dev"}}
        for name in linked.keys() & wanted.keys():
            self.assertEqual(wanted[name] - linked[name], set(), name)
        self.assertNotIn("libgtest-dev", set().union(*linked.values()), "what only the tests use")
        if "stillpoint" in contained:
            self.assertEqual(contained["stillpoint"], {"third_party/uplot"})
        self.assertEqual(contained.get("stillpointd", set()), set())

    def test_the_document_keeps_to_spdx_2_3(self):
        b = self.bill
        self.assertEqual((b["spdxVersion"], b["dataLicense"], b["SPDXID"]), ("SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"))
        self.assertTrue(b["name"])
        self.assertRegex(b["documentNamespace"], r"^https://[^#\s]+$")
        datetime.datetime.strptime(b["creationInfo"]["created"], "%Y-%m-%dT%H:%M:%SZ")
        for creator in b["creationInfo"]["creators"]:
            self.assertRegex(creator, r"^(Person|Organization|Tool): .+")
        elements = [b["SPDXID"], *(p["SPDXID"] for p in b["packages"]), *(f["SPDXID"] for f in b["files"])]
        self.assertEqual(len(elements), len(set(elements)))
        for element in elements:
            self.assertRegex(element, r"^SPDXRef-[A-Za-z0-9.-]+$")
        for r in b["relationships"]:
            self.assertIn(r["relationshipType"], KINDS)
            self.assertIn(r["spdxElementId"], elements)
            self.assertIn(r["relatedSpdxElement"], elements)
        described = self.related("SPDXRef-DOCUMENT", "DESCRIBES")
        self.assertEqual(described, {self.by_name[p.name]["SPDXID"] for p in self.programs})
        for f in b["files"]:
            self.assertTrue((SOURCE / f["fileName"]).is_file(), f["fileName"])
            self.assertIn("SHA1", {c["algorithm"] for c in f["checksums"]})
        for p in b["packages"]:
            self.assertEqual(p["filesAnalyzed"], "packageVerificationCode" in p, p["name"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], "--verbose"])
