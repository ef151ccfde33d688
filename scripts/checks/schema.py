#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""schema.py [ROOT]: every bundled *.variables.json obeys docs/variables.schema.json."""
import json
import pathlib
import sys

SKIPPED = 77


def main():
    try:
        import jsonschema
    except ImportError:
        print("no python3-jsonschema")
        return SKIPPED
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    files = sorted((root / "scenes").rglob("*.variables.json"))
    schema_path = root / "docs/variables.schema.json"
    if not schema_path.exists() and not files:
        print("no docs/variables.schema.json and no *.variables.json")
        return SKIPPED
    schema = json.loads(schema_path.read_text(encoding="utf-8"))
    validator_class = jsonschema.validators.validator_for(schema)
    validator_class.check_schema(schema)
    validator = validator_class(schema)
    failed = False
    for path in files:
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
        except ValueError as error:
            print(f"{path.relative_to(root)}: {error}")
            failed = True
            continue
        for error in validator.iter_errors(document):
            print(f"{path.relative_to(root)}: {error.json_path}: {error.message}")
            failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
