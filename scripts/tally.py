#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""tally.py PREFIX JUNIT: CTest's report as lines "status<TAB>PREFIX name<TAB>reason"."""
import re
import sys
import xml.etree.ElementTree as ElementTree


def reason_of(case):
    """The line in which the test says why it skips, else CTest's own words."""
    text = (case.findtext("system-out") or "").strip().splitlines()
    for line in reversed(text):
        if re.search("skip|no |not ", line, re.I) and "cmocka" not in line:
            return re.sub(r"\s+", " ", line.strip())
    skipped = case.find("skipped")
    return skipped.get("message", "") if skipped is not None else ""


def main():
    prefix, path = sys.argv[1:3]
    for case in ElementTree.parse(path).getroot().iter("testcase"):
        status = {"run": "passed", "fail": "failed"}.get(case.get("status"), "skipped")
        name = f"{prefix} {case.get('name')}"
        print(status, name, reason_of(case) if status == "skipped" else "", sep="\t")


if __name__ == "__main__":
    main()
